// SPDX-License-Identifier: MIT
// nlo monitor: adds alarms to a model, which detect in flight that its estimates are wrong.
#include <fmt/core.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/model/model.h"
#include "codegen/model_file/model_file.h"
#include "trainer/app/commands/command.h"
#include "trainer/app/commands/directory_lock.h"
#include "trainer/app/commands/input_facts.h"
#include "trainer/app/commands/options.h"
#include "trainer/app/commands/output_directory.h"
#include "trainer/app/commands/patient_progress.h"
#include "trainer/base/number_text.h"
#include "trainer/base/printable.h"
#include "trainer/data/log_dataset.h"
#include "trainer/experiments/mirrored_channels.h"
#include "trainer/judge/compare/compared_runs.h"
#include "trainer/judge/compare/runs_under.h"
#include "trainer/judge/compare/study.h"
#include "trainer/judge/evaluation/text.h"
#include "trainer/judge/monitor/fit_monitor.h"
#include "trainer/judge/monitor/monitor_study.h"
#include "trainer/judge/monitor/sensed_runs.h"

namespace nlo::trainer {
namespace {

/// Returns "innovation_mean" and so on; "" without an alarm.
const char* alarm_name(nlo::Alarm alarm) {
  constexpr std::array<const char*, 8> kNames = {"",
                                                 "innovation_mean",
                                                 "innovation_variance",
                                                 "innovation_correlation",
                                                 "latent_distance",
                                                 "missing",
                                                 "disagreement",
                                                 "reset"};
  return kNames[static_cast<std::size_t>(alarm)];
}

// Smallest expected number of alarms on the test logs; with fewer alarms their rate is not significant.
constexpr double kEnoughAlarms = 3.0;

/// Returns one line for each sensor fault that harms the estimate without an alarm. These lines come first.
std::string undetected_text(const std::vector<FaultRow>& faults) {
  std::string text;
  for (const FaultRow& row : faults)
    if (row.undetected())
      text += fmt::format(
          "NOT DETECTED: {} {}: the error becomes {} times as large, but only {} of {} harmed runs have an alarm\n",
          row.output, fault_name(row.fault), significant(row.error), row.seen, row.harmed);
  return text.empty() ? text : text + "\n";
}

std::string gate_text(const FittedMonitor& fitted) {
  std::string text;
  for (const std::string& why : fitted.gate.dropped) text += fmt::format("not used: {}\n", why);
  if (fitted.gate.trials.empty()) return text;
  Table table{{"gate tried", "error without", "error with", "cost"}};
  for (const GateTrial& trial : fitted.gate.trials)
    table.add_row({trial.when, significant(trial.plain), significant(trial.gated), significant(trial.cost())});
  text += "\nrms error in deviations of the states, from the first sample on, on runs that did not set the gate\n\n" +
          table.to_text(1, 110);
  if (const std::optional<GateTrial>& lost = fitted.gate.replacing; lost)
    text += fmt::format(
        "if 4 % of the readings are lost: error {} with the last reading held, {} with the predicted one; "
        "the observer gets the {}\n",
        significant(lost->plain), significant(lost->gated),
        fitted.monitor.replaces_any() ? "predicted one" : "last one");
  return text;
}

std::string faults_text(const std::vector<FaultRow>& faults) {
  if (faults.empty()) return "";
  Table table{{"sensor fails", "fault", "error times", "harmed", "alarm", "median [s]", "first alarm"}};
  for (const FaultRow& row : faults)
    table.add_row({row.output, fault_name(row.fault), significant(row.error), std::to_string(row.harmed),
                   row.harmed == 0 ? "" : fmt::format("{} of {}", row.seen, row.harmed),
                   significant(row.median_delay_s), alarm_name(row.most)});
  return "\nan output fails in the middle of a run. error times: error / error without the fault; harmed: runs whose\n"
         "error doubles; alarm: harmed runs with an alarm from the fault on\n\n" +
         table.to_text(2, 110);
}

std::string log_rate_text(const codegen::Monitor& monitor, const MonitorStudy& study) {
  if (!study.on_logs) return "";
  if (study.log_hours * monitor.false_alarms_per_hour < kEnoughAlarms)
    return fmt::format("alarms per hour in nominal flight: unknown, because {} h of test logs are too short\n",
                       significant(study.log_hours));
  return fmt::format(
      "on the test logs, {} h: {} alarms per hour{}{}{}\n", significant(study.log_hours),
      significant(study.on_logs->per_hour), study.on_logs->most == Alarm::kNone ? "" : ", mostly ",
      alarm_name(study.on_logs->most),
      study.on_logs->per_hour > 2.0 * monitor.false_alarms_per_hour ? ", more than twice the requested rate" : "");
}

std::string conditions_text(const MonitorStudy& study) {
  if (study.rows.empty()) return "";
  std::string text = fmt::format(
      "\n{} runs of {} s for each condition, time constant {} s, once armed. error: norm of x - x_hat; ratio: error /\n"
      "error of the first row; seen: runs with an alarm within five time constants; gated: error behind the gate\n\n",
      study.runs, significant(study.horizon_s), significant(study.time_constant_s));
  Table table{{"condition", "error", "ratio", "seen", "median [s]", "alarms/h", "gated", "rejected", "first alarm"}};
  for (const MonitorRow& row : study.rows)
    table.add_row({row.condition, significant(row.error), significant(row.ratio),
                   fixed(100.0 * row.alarms.seen, 1) + " %", significant(row.alarms.median_delay_s),
                   significant(row.alarms.per_hour), significant(row.gated), fixed(100.0 * row.rejected, 2) + " %",
                   alarm_name(row.alarms.most)});
  text += table.to_text(2, 110);
  if (!study.left_out.empty())
    text += fmt::format("\nleft out, because the plant has no parameters: {}\n", fmt::join(study.left_out, ", "));
  for (const std::string& why : study.impossible) text += fmt::format("left out: {}\n", why);
  return text;
}

std::string monitor_text(const FittedMonitor& fitted, const MonitorStudy& study) {
  const codegen::Monitor& monitor = fitted.monitor;
  const bool gated = monitor.gate < std::sqrt(kNoLimit);
  std::string text = undetected_text(study.faults);
  text += fmt::format("limits for {} false alarms per hour, from {} h of runs as in training; {}\n",
                      significant(monitor.false_alarms_per_hour), significant(monitor.hours),
                      gated ? fmt::format("gate at {} deviations of the innovation", significant(monitor.gate))
                            : "the gate is open: it rejects nothing");
  for (const std::string& note : fitted.notes) text += note + "\n";
  text += log_rate_text(monitor, study);
  if (!fitted.unwatched.empty())
    text += fmt::format("not watched, because values in training are already close to the largest possible value: {}\n",
                        fmt::join(fitted.unwatched, ", "));
  return text + gate_text(fitted) + faults_text(study.faults) + conditions_text(study);
}

std::string monitor_json(const FittedMonitor& fitted, const MonitorStudy& study) {
  const codegen::Monitor& monitor = fitted.monitor;
  nlohmann::ordered_json json;
  json["false_alarms_per_hour"] = monitor.false_alarms_per_hour;
  json["hours"] = monitor.hours;
  json["gate"] = monitor.gate;
  json["time_constant_s"] = monitor.windows_s(1);
  json["armed_after_s"] = monitor.armed_after_s;
  json["notes"] = fitted.notes;
  json["runs"] = study.runs;
  if (study.on_logs) json["test_logs"] = {{"hours", study.log_hours}, {"alarms_per_hour", study.on_logs->per_hour}};
  json["gate_dropped"] = fitted.gate.dropped;
  for (const GateTrial& trial : fitted.gate.trials) json["gate_cost"][trial.when] = trial.cost();
  if (const std::optional<GateTrial>& lost = fitted.gate.replacing; lost)
    json["lost_readings"] = {{"held", lost->plain}, {"predicted", lost->gated}, {"replaces", monitor.replaces_any()}};
  json["not_watched"] = fitted.unwatched;
  for (const FaultRow& row : study.faults) {
    nlohmann::ordered_json& one = json["faults"][row.output][fault_name(row.fault)];
    one["error_ratio"] = row.error;
    one["runs_harmed"] = row.harmed;
    one["runs_seen"] = row.seen;
    if (row.median_delay_s) one["median_delay_s"] = *row.median_delay_s;
    one["first_alarm"] = alarm_name(row.most);
  }
  json["left_out"] = study.impossible;
  for (const MonitorRow& row : study.rows) {
    nlohmann::ordered_json& one = json["conditions"][row.condition];
    one["error"] = row.error;
    one["ratio"] = row.ratio;
    one["seen"] = row.alarms.seen;
    if (row.alarms.median_delay_s) one["median_delay_s"] = *row.alarms.median_delay_s;
    one["alarms_per_hour"] = row.alarms.per_hour;
    one["first_alarm"] = alarm_name(row.alarms.most);
    one["error_behind_the_gate"] = row.gated;
    one["rejected"] = row.rejected;
  }
  return json.dump(2) + "\n";
}

constexpr double kHour = 3600.0;
constexpr int kFitRuns = 100;
constexpr double kMostSamples = 4e6;  // largest number of samples of the runs for the limits
constexpr int kFewestLimitRuns = 30;  // slow plants: 210 time constants in all
constexpr int kChunk = 64;            // runs in memory together
constexpr int kTrialRuns = 24;        // runs for the trial of the gate
constexpr Eigen::Index kMostTrialSamples = 20000;
constexpr std::uint64_t kTrialSeed = 0x67617465ULL;
constexpr std::uint64_t kFitSeed = 0x6d6f6e69ULL, kCleanSeed = kFitSeed + 1, kLimitSeed = kFitSeed + 1000;

struct MonitorArguments {
  std::string model, data, noise, conditions, output;
  MonitorRequest request{.false_alarms_per_hour = 0.0, .time_constant_s = 0.0};
  double hours = 12.0;
  int runs = 200;
  unsigned long long seed = 1;
  bool json = false, quick = false, dry_run = false, accept_undetected = false;
};

std::vector<NoiseConfig> noises_of(const MonitorArguments& arguments, const Experiment& experiment) {
  if (arguments.noise.empty()) return experiment.training.all_noise().parts;
  const NoiseConfig noise = parse_noise(arguments.noise);
  check_noise(noise, experiment.plant->outputs.empty() ? noise.sensors.size() : experiment.plant->outputs.size());
  return {noise};
}

/// Returns `hours`, or fewer if runs of this length had too many samples.
double affordable_hours(double hours, double sample_period_s) {
  return std::min(hours, kMostSamples * sample_period_s / kHour);
}

/// Writes the model while no training uses the folder. If the file no longer contains `read`, it is not replaced.
void write(const codegen::Model& model, const std::string& output, const std::string& origin, const std::string& read) {
  constexpr auto kPatience = std::chrono::seconds(2);  // time in which another `nlo monitor` may write
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

/// Chooses the time constant and the rate of false alarms if the user has not given them. Returns notes on unusual
/// values. Throws codegen::Error for a rate that is too high for the time constant.
std::vector<std::string> choose_times(MonitorRequest& request, const codegen::Model& model, const SensedRuns& runs,
                                      bool recorded) {
  TimeConstant chosen{request.time_constant_s};
  if (request.time_constant_s == 0.0) chosen = time_constant(model, runs, recorded);
  request.time_constant_s = chosen.seconds;
  std::vector<std::string> notes;
  if (!chosen.note.empty()) notes.push_back(chosen.note);
  // An alarm lasts for about a time constant.
  constexpr double kUsualPerHour = 1.0, kUsual = 0.01, kMost = 0.5;
  const double per_hour = kHour / chosen.seconds;
  if (request.false_alarms_per_hour > kMost * per_hour)
    throw codegen::Error(
        fmt::format("--false-alarms-per-hour {}: an alarm lasts about a time constant, here {:.3g} s, so alarms would "
                    "be active most of the time; ask for at most {:.3g}",
                    request.false_alarms_per_hour, chosen.seconds, kMost * per_hour));
  if (request.false_alarms_per_hour > 0.0) return notes;
  request.false_alarms_per_hour = std::min(kUsualPerHour, kUsual * per_hour);
  if (request.false_alarms_per_hour < kUsualPerHour)
    notes.push_back(fmt::format("{} false alarms per hour instead of {}: one in 100 time constants of {:.3g} s",
                                significant(request.false_alarms_per_hour), kUsualPerHour, chosen.seconds));
  return notes;
}

FittedMonitor monitor_of_plant(const codegen::Model& model, const Experiment& experiment,
                               const std::vector<NoiseConfig>& noises, MonitorRequest& request, double hours,
                               const MonitorProgress& progress) {
  const double horizon_s = experiment.simulation.horizon_s;
  const SensedRuns fit = sensed_runs(experiment, noises, horizon_s, kFitSeed, kFitRuns);
  const std::vector<std::string> notes = choose_times(request, model, fit, false);
  const double long_run_s = std::max(horizon_s, 8.0 * request.time_constant_s);
  const int count = std::max(kFewestLimitRuns, static_cast<int>(std::ceil(hours * kHour / long_run_s)));
  const RunSource limits{[&](int chunk) {
                           return sensed_runs(experiment, noises, long_run_s,
                                              kLimitSeed + static_cast<std::uint64_t>(chunk),
                                              std::min(kChunk, count - chunk * kChunk));
                         },
                         (count + kChunk - 1) / kChunk};
  const SensedRuns clean = sensed_runs(experiment, {NoiseConfig{}}, long_run_s, kCleanSeed, kFitRuns / 2);
  Experiment nominal = nominal_experiment(experiment);
  nominal.simulation.horizon_s = long_run_s;
  const std::vector<FlownRun> trial = flown_runs(compared_runs(nominal, trained_condition(experiment, noises.front()),
                                                               SeedStream::kValidation, kTrialSeed, 1, kTrialRuns),
                                                 kMostTrialSamples);
  FittedMonitor fitted = fit_monitor(model, fit, limits, clean, trial, request, progress);
  fitted.notes.insert(fitted.notes.begin(), notes.begin(), notes.end());
  return fitted;
}

/// Fits predictions and the gate on training logs, and limits on these and the validation logs. The gate is tested on
/// the validation logs, which were not used to set it.
FittedMonitor monitor_of_logs(const codegen::Model& model, const LogSplits& splits, MonitorRequest& request) {
  Dataset logs = splits.train;
  logs.uniform = logs.uniform && splits.validation.uniform;
  logs.trajectories.insert(logs.trajectories.end(), splits.validation.trajectories.begin(),
                           splits.validation.trajectories.end());
  const SensedRuns fit = sensed_runs(splits.train), all = sensed_runs(logs);
  const std::vector<std::string> notes = choose_times(request, model, all, true);
  const Dataset& trial = splits.validation.trajectories.empty() ? splits.train : splits.validation;
  FittedMonitor fitted = fit_monitor(model, fit, {[&](int) { return all; }, 1}, std::nullopt,
                                     flown_runs(trial, kMostTrialSamples), request);
  fitted.notes.insert(fitted.notes.begin(), notes.begin(), notes.end());
  return fitted;
}

void run_monitor(MonitorArguments arguments) {
  const std::string read = codegen::read_file(arguments.model);
  codegen::Model model = codegen::parse_model(read, arguments.model);
  Experiment experiment = experiment_of(model, arguments.model);
  experiment.threads = arguments.request.threads;
  if (experiment.log && arguments.data.empty())
    throw codegen::Error(fmt::format(
        "{}: was trained on logs, and a monitor needs them too; name their directory: --data DIR", arguments.model));
  if (experiment.log && (!arguments.noise.empty() || !arguments.conditions.empty()))
    throw codegen::Error("--noise and --conditions are for simulated plants, but this model was trained on logs");
  if (!experiment.log && !arguments.data.empty())
    throw codegen::Error(
        fmt::format("--data: {} was trained on a simulated [plant]; leave --data out", arguments.model));
  const std::string output = arguments.output.empty() ? arguments.model : arguments.output;
  if (is_stdout(output)) throw codegen::Error("-o -: stdout has the table; name a file for the model");
  if (!arguments.dry_run) check_output_file(output);
  ConditionSet set;
  std::vector<NoiseConfig> noises;
  if (!experiment.log) {
    noises = noises_of(arguments, experiment);
    set = arguments.conditions.empty() ? default_conditions() : read_conditions(arguments.conditions);
    std::vector<std::string> left_out;
    (void)compared_conditions(experiment, set, left_out);  // reports errors in the conditions before the long work
  }
  constexpr double kQuickHours = 1.0;
  constexpr int kQuickRuns = 20;
  if (arguments.quick) arguments.hours = std::min(arguments.hours, kQuickHours);
  if (arguments.quick) arguments.runs = std::min(arguments.runs, kQuickRuns);
  const double hours = affordable_hours(arguments.hours, model.sample_period_s);

  PatientProgress progress;
  run_phase([&] {
    constexpr double kLimitsShare = 0.6;  // share of the work
    LogSplits splits;
    if (experiment.log) splits = load_log_splits(*experiment.log, arguments.data, mirrored_channels(experiment));
    model.monitor.reset();
    const FittedMonitor fitted =
        experiment.log ? monitor_of_logs(model, splits, arguments.request)
                       : monitor_of_plant(model, experiment, noises, arguments.request, hours,
                                          [&](double share) { progress.update(kLimitsShare * share, "limits"); });
    model.monitor = fitted.monitor;
    MonitorStudy study = study_on_logs(model, splits.test.trajectories.empty() ? splits.validation : splits.test,
                                       arguments.request.threads);
    if (!experiment.log && arguments.runs > 0)
      study = study_monitor(
          model, experiment, trained_condition(experiment, noises.front()), set, arguments.request.time_constant_s,
          arguments.runs, hours / 4.0, arguments.seed, arguments.request.threads,
          [&](double share) { progress.update(kLimitsShare + (1.0 - kLimitsShare) * share, "conditions"); });
    if (!arguments.dry_run) write(model, output, arguments.model, read);
    progress.finish();
    if (arguments.json) {
      fmt::print("{}", monitor_json(fitted, study));
    } else {
      fmt::print("{}", printable(monitor_text(fitted, study)));
      if (!arguments.dry_run) fmt::print("\nmodel    {}, with its monitor: nlo export\n", output);
    }
    if (!arguments.accept_undetected && !undetected_text(study.faults).empty())
      throw RunFailure(
          fmt::format("{}: a dead, frozen or zero sensor harms the estimate without an alarm (first lines of the "
                      "table); monitor that sensor by other means, then add --accept-undetected",
                      arguments.model));
  });
}

}  // namespace

void add_monitor(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<MonitorArguments>();
  CLI::App* command =
      app.add_subcommand("monitor", "Add a monitor to a model: alarms in flight when its estimates are wrong");
  Options options(*command);
  options.value("MODEL", arguments->model, "model.json of nlo train; an existing monitor in it is replaced")
      ->required();
  options.directory("--data", arguments->data, "directory of its training logs");
  options
      .value("--false-alarms-per-hour", arguments->request.false_alarms_per_hour,
             "false alarms per hour of flight with sensors and plant as in training (default: 1, or 1 in 100 time "
             "constants if that is less)",
             "N")
      ->check(CLI::Range(1e-3, 1e3));
  options
      .value("--time-constant", arguments->request.time_constant_s,
             "time constant of the averages [s] (default: that of the slowest mode, or the period of the outputs)", "S")
      ->check(CLI::Range(1e-9, 1e9));
  options.value("--noise", arguments->noise, "noise of the sensors in flight (default: that of the training)");
  options.number("--hours", arguments->hours, 1e-3, 1e4,
                 "hours of simulated runs for the limits; at most 4 million samples");
  options.value("--conditions", arguments->conditions,
                "conditions of the test, as for nlo evaluate (default: twenty that fit any plant)", "FILE.toml");
  options.number("--runs", arguments->runs, 0, 100000, "number of test runs of each condition; 0: no test");
  options.seed(arguments->seed, "seed of the test runs");
  options.flag("--quick", arguments->quick,
               "at most an hour of runs for the limits, and 20 test runs of each condition");
  options.threads(arguments->request.threads);
  options.value("-o,--output", arguments->output, "file for the model with its monitor (default: MODEL)", "FILE.json");
  options.flag("--dry-run", arguments->dry_run, "print the table, but write no model");
  options.flag("--accept-undetected", arguments->accept_undetected,
               "exit with 0 even if a dead, frozen or zero sensor raises no alarm");
  options.flag("--json", arguments->json, "one JSON object instead of the table");
  command->footer(
      "Examples:\n"
      "  nlo monitor runs/van_der_pol/model.json\n"
      "  nlo monitor runs/battery/model.json --data logs --false-alarms-per-hour 0.1\n"
      "  nlo export runs/van_der_pol/model.json -o van_der_pol.h    # with nlo::van_der_pol::kMonitor");
  command->callback([arguments, &action] { action = [arguments] { run_monitor(*arguments); }; });
}

}  // namespace nlo::trainer
