// SPDX-License-Identifier: MIT
// nlo report: writes the report.html of a run again, with more tests than training did, or with the control loop that
// has run since.
#include <fmt/core.h>
#include <fmt/format.h>

#include <memory>

#include "codegen/model_file/model_file.h"
#include "trainer/app/commands/command.h"
#include "trainer/app/commands/options.h"
#include "trainer/app/commands/output_directory.h"
#include "trainer/app/commands/run_report.h"
#include "trainer/experiments/mirrored_channels.h"
#include "trainer/plants/plant_registry.h"

namespace nlo::trainer {
namespace {

struct ReportArguments {
  std::string directory, data, output;
  std::vector<std::string> noises;
  StudyTest test;
};

void run_report(ReportArguments arguments) {
  std::vector<NoiseConfig> noises;
  for (const std::string& noise : arguments.noises) noises.push_back(parse_noise(noise));
  arguments.test.conditions = conditions_of(noises);
  const std::string file = arguments.directory + "/model.json";
  const codegen::Model model = codegen::read_model(file);
  const Experiment experiment = experiment_of(model, file);
  if (arguments.output.empty()) arguments.output = arguments.directory + "/report.html";
  check_output_file(arguments.output);
  RunReport report;
  if (experiment.plant) {
    for (const NoiseConfig& noise : noises) check_noise(noise, make_plant(*experiment.plant)->outputs().size());
    if (!arguments.data.empty()) throw codegen::Error(file + ": was trained on a simulated plant; leave --data out");
    report = run_phase([&] { return report_on_plant(model, experiment, arguments.test); });
  } else {
    if (arguments.data.empty()) throw codegen::Error(file + ": was trained on logs; name their directory: --data DIR");
    const LogSplits splits = load_log_splits(*experiment.log, arguments.data, mirrored_channels(experiment));
    report = run_phase(
        [&] { return report_on_logs(model, experiment, splits.train, logs_to_report_on(splits), splits.report); });
  }
  run_phase([&] { write_output_file(arguments.output, run_report_page(model, report, arguments.directory)); });
  if (!is_stdout(arguments.output)) fmt::print("report   {}\n", arguments.output);
}

}  // namespace

void add_report(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<ReportArguments>();
  CLI::App* command = app.add_subcommand("report", "Write the report.html of a run again");
  Options options(*command);
  options.value("DIR", arguments->directory, "output directory of nlo train")->required();
  options.repeated("--noise", arguments->noises,
                   "noise, as for nlo evaluate; may be repeated (default: no noise, and the noise of the training)");
  options.list("--against", arguments->test.against, "alternatives: ekf, ukf, mhe, high_gain (know the plant exactly)")
      ->check(CLI::IsMember(alternative_names()));
  options.seed(arguments->test.seed, "seed of the initial states and the noise");
  options.value("-o,--output", arguments->output, "file to write (DIR/report.html); - for stdout", "FILE");
  options.directory("--data", arguments->data, "directory of the logs, for a model trained on logs");
  command->footer(
      "Example:\n"
      "  nlo report runs/van_der_pol --noise none --noise gaussian:0.5 --noise uniform:3 --against ekf");
  command->callback([arguments, &action] { action = [arguments] { run_report(*arguments); }; });
}

}  // namespace nlo::trainer
