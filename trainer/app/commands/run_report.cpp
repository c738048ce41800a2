// SPDX-License-Identifier: MIT
#include "trainer/app/commands/run_report.h"

#include <cmath>

#include "codegen/base/file.h"
#include "trainer/app/report/report.h"
#include "trainer/data/log_schema.h"
#include "trainer/judge/evaluation/evaluation_text.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {

RunReport report_on_plant(const codegen::Model& model, const Experiment& experiment, StudyTest test) {
  if (test.conditions.empty()) {
    std::vector<NoiseConfig> noises(1);
    for (const NoiseConfig& noise : experiment.training.all_noise().parts)
      if (!noise.none()) noises.push_back(noise);
    test.conditions = conditions_of(noises, {.input_noise = experiment.training.input_noise});
  }
  RunReport report;
  report.rows = run_study({{model.name, model}}, experiment, test).rows;
  return report;
}

ReportedLogs logs_to_report_on(const LogSplits& splits) {
  if (!splits.test.trajectories.empty()) return {splits.test, "test"};
  if (!splits.validation.trajectories.empty()) return {splits.validation, "validation"};
  return {splits.train, "training"};
}

RunReport report_on_logs(const codegen::Model& model, const Experiment& experiment, const Dataset& training,
                         const ReportedLogs& judged, const LogReport& clock) {
  RunReport report;
  report.log_clock = clock;
  const LogSchema schema = resolve_columns(*experiment.log);
  for (const LogColumn& state : schema.states)
    if (state.derivative) report.derived_states.push_back(state.name);
  LogEvaluation& logs = report.logs.emplace(evaluate_on_logs(model, judged.logs, schema, &training, NoiseConfig{},
                                                             experiment.seed, metrics_config(experiment, judged.logs)));
  logs.split = judged.split;
  if (judged.split == "validation")
    logs.notes.insert(logs.notes.begin(),
                      "These are the validation logs, which were used to select the model: errors on new logs may be "
                      "larger. Name some logs as test_files in [log].");
  if (judged.split == "training")
    logs.notes.insert(logs.notes.begin(),
                      "These are the training logs: errors on other logs may be much larger. Name logs as "
                      "validation_files and test_files in [log].");
  return report;
}

namespace {

std::string readout_table(const RunReport& report) {
  const Readout& readout = report.readout;
  if (readout.empty()) return "";
  const std::string window = report.readout_by_settled ? "settled RMSE" : "RMSE";
  Table table{{window + (report.groups > 0 ? ", logs left out of a training" : ", training or validation"), "network",
               "linear row", "sensor", "shipped", "what ships"}};
  for (const StateReadout& s : readout)
    table.add_row({s.state, significant(s.trained), significant(s.linear), significant(s.sensor),
                   significant(s.shipped), readout_text(s)});
  return table.to_text(2) + "\n";
}

}  // namespace

std::string run_report_text(const codegen::Model& model, const RunReport& report) {
  std::string text;
  for (const StudyRow& row : report.rows) text += evaluation_text(row);
  if (report.logs) text += evaluation_text(model.name, *report.logs);
  return text + readout_table(report);
}

std::string run_report_page(const codegen::Model& model, const RunReport& report, const std::string& directory) {
  ReportData data = report_of(model, directory);
  data.rows = report.rows;
  data.logs = report.logs;
  data.log_clock = report.log_clock;
  data.derived_states = report.derived_states;
  data.warning = report.warning;
  return render_report(data);
}

void write_run_report(const codegen::Model& model, const RunReport& report, const std::string& directory) {
  codegen::write_file_atomically(directory + "/report.html", run_report_page(model, report, directory));
}

}  // namespace nlo::trainer
