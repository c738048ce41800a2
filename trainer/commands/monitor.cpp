// SPDX-License-Identifier: MIT
// nlo monitor: gives a model what says, in flight, that it is wrong.
#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <system_error>

#include "codegen/base/file.h"
#include "codegen/model_file/model_file.h"
#include "trainer/base/number_text.h"
#include "trainer/base/printable.h"
#include "trainer/commands/command.h"
#include "trainer/commands/directory_lock.h"
#include "trainer/commands/input_delays.h"
#include "trainer/commands/output_directory.h"
#include "trainer/commands/patient_progress.h"
#include "trainer/compare/compare_study.h"
#include "trainer/compare/strict_study.h"
#include "trainer/data/log_dataset.h"
#include "trainer/monitor/fit_monitor.h"
#include "trainer/monitor/monitor_study.h"
#include "trainer/monitor/monitor_text.h"
#include "trainer/monitor/sensed_runs.h"
#include "trainer/monitor/time_constant.h"

namespace nlo::trainer {
namespace {

constexpr double kHour = 3600.0;
constexpr int kFitRuns = 100;
constexpr double kMostSamples = 4e6;  // of the runs that limits are set on
constexpr int kChunk = 64;            // runs in memory together
constexpr std::uint64_t kFitSeed = 0x6d6f6e69ULL, kCleanSeed = kFitSeed + 1, kLimitSeed = kFitSeed + 1000;

struct MonitorArguments {
  std::string model, data, noise, conditions, output;
  MonitorRequest request{.false_alarms_per_hour = 1.0, .time_constant_s = 0.0};
  double hours = 12.0;
  int runs = 200;
  unsigned long long seed = 1;
  bool json = false, quick = false, dry_run = false;
};

std::vector<NoiseConfig> noises_of(const MonitorArguments& arguments, const Experiment& experiment) {
  if (arguments.noise.empty()) return experiment.training.all_noise().parts;
  const NoiseConfig noise = parse_noise(arguments.noise);
  check_noise(noise, experiment.plant->outputs.empty() ? noise.sensors.size() : experiment.plant->outputs.size());
  return {noise};
}

/// Hours of runs, fewer where that were too many samples.
double affordable_hours(double hours, double sample_period_s) {
  return std::min(hours, kMostSamples * sample_period_s / kHour);
}

/// No training is at work in the folder while the model is written,
/// and one that has been since `read` was read is kept.
void write(const codegen::Model& model, const std::string& output, const std::string& origin, const std::string& read) {
  constexpr auto kPatience = std::chrono::seconds(2);  // another monitor is written in the meantime
  const std::filesystem::path folder = std::filesystem::path(output).parent_path();
  DirectoryLock lock;
  lock.take(folder.empty() ? "." : folder.string(), kPatience);
  std::error_code ignored;
  if (output == origin || std::filesystem::equivalent(output, origin, ignored)) {
    codegen::rewrite_model(model, output, read);
  } else {
    codegen::write_model(model, output);
  }
}

codegen::Monitor monitor_of_plant(const codegen::Model& model, const Experiment& experiment,
                                  const std::vector<NoiseConfig>& noises, MonitorRequest& request, double hours,
                                  const MonitorProgress& progress) {
  const double horizon_s = experiment.simulation.horizon_s;
  const SensedRuns fit = sensed_runs(experiment, noises, horizon_s, kFitSeed, kFitRuns);
  if (request.time_constant_s == 0.0) request.time_constant_s = time_constant_s(model, fit);
  const double long_run_s = std::max(horizon_s, 8.0 * request.time_constant_s);
  const auto count = static_cast<int>(std::ceil(hours * kHour / long_run_s));
  const RunSource limits{[&](int chunk) {
                           return sensed_runs(experiment, noises, long_run_s,
                                              kLimitSeed + static_cast<std::uint64_t>(chunk),
                                              std::min(kChunk, count - chunk * kChunk));
                         },
                         (count + kChunk - 1) / kChunk};
  const SensedRuns clean = sensed_runs(experiment, {NoiseConfig{}}, long_run_s, kCleanSeed, kFitRuns / 2);
  return fit_monitor(model, fit, limits, clean, request, progress);
}

/// Training and validation logs: the hours that there are.
codegen::Monitor monitor_of_logs(const codegen::Model& model, const LogSplits& splits, MonitorRequest& request) {
  Dataset logs = splits.train;
  logs.uniform = logs.uniform && splits.validation.uniform;
  logs.trajectories.insert(logs.trajectories.end(), splits.validation.trajectories.begin(),
                           splits.validation.trajectories.end());
  const SensedRuns all = sensed_runs(logs);
  if (request.time_constant_s == 0.0) request.time_constant_s = time_constant_s(model, all);
  return fit_monitor(model, all, {[&](int) { return all; }, 1}, std::nullopt, request);
}

/// The table's conditions do not say what the training's sensors are; these do.
Condition trained_condition(const std::vector<NoiseConfig>& noises, const Experiment& experiment) {
  Condition condition;
  condition.name = "as_trained";
  condition.noise = noises.front();
  condition.process_noise = experiment.simulation.process_noise;
  return condition;
}

void run_monitor(MonitorArguments arguments) {
  const std::string read = codegen::read_file(arguments.model);
  codegen::Model model = codegen::parse_model(read, arguments.model);
  Experiment experiment = experiment_of(model, arguments.model);
  experiment.threads = arguments.request.threads;
  if (experiment.log && arguments.data.empty())
    throw codegen::Error(
        fmt::format("{}: was trained on logs, which a monitor is made from too; name their directory: --data DIR",
                    arguments.model));
  if (experiment.log && (!arguments.noise.empty() || !arguments.conditions.empty()))
    throw codegen::Error(
        "--noise and --conditions are about plants that are simulated; this model was trained on logs");
  if (!experiment.log && !arguments.data.empty())
    throw codegen::Error(fmt::format("--data: {} was trained on a simulated [plant]; leave it out", arguments.model));
  const std::string output = arguments.output.empty() ? arguments.model : arguments.output;
  if (is_stdout(output)) throw codegen::Error("-o -: stdout has the table; name a file for the model");
  if (!arguments.dry_run) check_output_file(output);
  ConditionSet set;
  std::vector<NoiseConfig> noises;
  if (!experiment.log) {
    noises = noises_of(arguments, experiment);
    set = arguments.conditions.empty() ? default_conditions() : read_conditions(arguments.conditions);
    std::vector<std::string> left_out;
    (void)compared_conditions(experiment, set, left_out);  // its refusals come first
  }
  constexpr double kQuickHours = 1.0;
  constexpr int kQuickRuns = 20;
  if (arguments.quick) arguments.hours = std::min(arguments.hours, kQuickHours);
  if (arguments.quick) arguments.runs = std::min(arguments.runs, kQuickRuns);
  const double hours = affordable_hours(arguments.hours, model.sample_period_s);

  PatientProgress progress;
  run_phase([&] {
    constexpr double kLimitsShare = 0.6;  // of the work
    LogSplits splits;
    if (experiment.log) splits = load_log_splits(*experiment.log, arguments.data, experiment.training.mirror);
    model.monitor.reset();
    model.monitor = experiment.log
                        ? monitor_of_logs(model, splits, arguments.request)
                        : monitor_of_plant(model, experiment, noises, arguments.request, hours,
                                           [&](double share) { progress.update(kLimitsShare * share, "limits"); });
    MonitorStudy study = study_on_logs(model, splits.test);
    if (!experiment.log && arguments.runs > 0)
      study = study_monitor(
          model, experiment, trained_condition(noises, experiment), set, arguments.request.time_constant_s,
          arguments.runs, hours / 4.0, arguments.seed, arguments.request.threads,
          [&](double share) { progress.update(kLimitsShare + (1.0 - kLimitsShare) * share, "conditions"); });
    if (!arguments.dry_run) write(model, output, arguments.model, read);
    progress.finish();
    if (arguments.json) return fmt::print("{}", monitor_json(*model.monitor, study));
    fmt::print("{}", printable(monitor_text(*model.monitor, study)));
    if (!arguments.dry_run) fmt::print("\nmodel    {}, with its monitor: nlo export\n", output);
  });
}

}  // namespace

void add_monitor(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<MonitorArguments>();
  CLI::App* command = app.add_subcommand(
      "monitor", "Give a model a monitor: alarms, in flight, when its estimates are not to be trusted");
  command
      ->add_option("MODEL", arguments->model,
                   "model.json of nlo train; it gets the monitor, in place of one that it has")
      ->required();
  command->add_option("--data", arguments->data, "directory of the logs it was trained on")->type_name("DIR");
  command
      ->add_option("--false-alarms-per-hour", arguments->request.false_alarms_per_hour,
                   "false alarms in an hour of the plant's time, with sensors and plant as in training")
      ->check(CLI::Range(1e-3, 1e3))
      ->capture_default_str();
  command
      ->add_option("--time-constant", arguments->request.time_constant_s,
                   "time constant of the averages [s] (default: of the slowest mode, or the period of the outputs)")
      ->check(CLI::Range(1e-9, 1e9))
      ->type_name("S");
  command->add_option("--noise", arguments->noise, "noise of the sensors in flight (default: that of the training)");
  command
      ->add_option("--hours", arguments->hours,
                   "hours of simulated runs that set the limits; at most 4 million samples")
      ->check(CLI::Range(1e-3, 1e4))
      ->capture_default_str();
  command
      ->add_option("--conditions", arguments->conditions,
                   "conditions to test it under, as for nlo compare (default: twenty that fit any plant)")
      ->type_name("FILE.toml");
  command->add_option("--runs", arguments->runs, "test runs of each condition; 0: no test")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  command->add_option("--seed", arguments->seed, "seed of the test runs")->check(check_seed)->capture_default_str();
  command->add_flag("--quick", arguments->quick,
                    "at most an hour of runs for the limits, and 20 test runs of each condition");
  command->add_option("--threads", arguments->request.threads, "0: all cores; does not change the result")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command->add_option("-o,--output", arguments->output, "file for the model with its monitor (default: MODEL)")
      ->type_name("FILE.json");
  command->add_flag("--dry-run", arguments->dry_run, "print the table, write no model");
  command->add_flag("--json", arguments->json, "one JSON object instead of the table");
  command->footer(
      "Examples:\n"
      "  nlo monitor runs/van_der_pol/model.json\n"
      "  nlo monitor runs/battery/model.json --data logs --false-alarms-per-hour 0.1\n"
      "  nlo export runs/van_der_pol/model.json -o van_der_pol.h    # with nlo::van_der_pol::kMonitor");
  command->callback([arguments, &action] { action = [arguments] { run_monitor(*arguments); }; });
}

}  // namespace nlo::trainer
