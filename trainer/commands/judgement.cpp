// SPDX-License-Identifier: MIT
#include "trainer/commands/judgement.h"

#include "trainer/analysis/evaluation_text.h"
#include "trainer/data/log_schema.h"
#include "trainer/report/report.h"

namespace nlo::trainer {

Judgement judge_on_plant(const codegen::Model& model, const Experiment& experiment, StrictTest test) {
  if (test.noises.empty()) {
    test.noises.emplace_back();
    if (experiment.training.noise.kind != NoiseKind::kNone) test.noises.push_back(experiment.training.noise);
  }
  Judgement judgement;
  judgement.evaluations = run_strict_test(model, experiment, test);
  return judgement;
}

Judgement judge_on_logs(const codegen::Model& model, const Experiment& experiment, const Dataset& training,
                        const Dataset& test, const LogReport& clock) {
  Judgement judgement;
  judgement.log_clock = clock;
  if (!test.trajectories.empty())
    judgement.logs =
        evaluate_on_logs(model, test, resolve_columns(*experiment.log), &training, NoiseConfig{}, experiment.seed);
  return judgement;
}

std::string judgement_text(const codegen::Model& model, const Judgement& judgement) {
  std::string text;
  for (const auto& evaluations : judgement.evaluations) text += evaluation_text(model.name, evaluations);
  if (judgement.logs) text += evaluation_text(model.name, *judgement.logs);
  return text;
}

void write_run_report(const codegen::Model& model, const Judgement& judgement, const std::string& directory) {
  ReportData data = report_of(model, directory);
  data.evaluations = judgement.evaluations;
  data.logs = judgement.logs;
  data.log_clock = judgement.log_clock;
  write_report(data, directory + "/report.html");
}

}  // namespace nlo::trainer
