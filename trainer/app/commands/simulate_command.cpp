// SPDX-License-Identifier: MIT
// nlo simulate: writes trajectories of a plant as CSV logs, to view them or to try training from logs.
#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "trainer/app/commands/command.h"
#include "trainer/app/commands/experiment_argument.h"
#include "trainer/app/commands/options.h"
#include "trainer/app/commands/output_directory.h"
#include "trainer/app/commands/run_files.h"
#include "trainer/base/number_text.h"
#include "trainer/base/printable.h"
#include "trainer/data/angle.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/plants/excitation.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/run_range.h"
#include "trainer/plants/simulate_runs.h"

namespace nlo::trainer {
namespace {

struct SimulateArguments {
  ExperimentArgument experiment;
  std::string output, noise = "none";
  std::vector<std::string> inputs;
  int trajectories = 1;
  unsigned long long seed = 1;
  bool draw_parameters = false;
};

constexpr int kMostTrajectories = 10000;

/// Returns the heading of an output. A state and an output may have the same name (y = x1 called "x1"); columns may
/// not.
std::string output_heading(const Dataset& data, std::size_t output) {
  const std::string& name = data.outputs[output].name;
  const bool taken =
      std::any_of(data.states.begin(), data.states.end(), [&](const Channel& s) { return s.name == name; });
  return taken ? name + "_clean" : name;
}

/// Returns angles as a sensor shows them, within half a turn of 0.
Eigen::MatrixXd shown(Eigen::MatrixXd values, const std::vector<Channel>& channels) {
  for (std::size_t i = 0; i < channels.size(); ++i)
    if (channels[i].wrap > 0.0)
      for (double& value : values.row(static_cast<Eigen::Index>(i))) value = wrap_difference(value, channels[i].wrap);
  return values;
}

std::string csv(const Dataset& data, int index, const Eigen::MatrixXd& measured) {
  const Trajectory& run = data.trajectories[static_cast<std::size_t>(index)];
  std::string text = "trajectory,time";
  for (std::size_t i = 0; i < data.outputs.size(); ++i) text += "," + output_heading(data, i);
  for (const Channel& output : data.outputs) text += "," + output.name + "_measured";
  for (const Channel& state : data.states) text += "," + state.name;
  for (const Channel& input : data.inputs) text += "," + input.name;
  text += "\n";
  const Eigen::MatrixXd outputs = shown(run.outputs, data.outputs), noisy = shown(measured, data.outputs),
                        states = shown(run.states, data.states);
  for (Eigen::Index k = 0; k < run.samples(); ++k) {
    text += fmt::format("{},{}", index + 1, shortest_text(run.time_s(k)));
    const auto append = [&](const Eigen::MatrixXd& values) {
      for (Eigen::Index i = 0; i < values.rows(); ++i) text += "," + shortest_text(values(i, k));
    };
    append(outputs);
    append(noisy);
    append(states);
    append(run.inputs);
    text += "\n";
  }
  return text;
}

void run_simulate(const SimulateArguments& arguments) {
  const NoiseConfig noise = parse_noise(arguments.noise);
  Experiment experiment = read_draft(arguments.experiment).experiment;
  if (!experiment.plant)
    throw codegen::Error(fmt::format("{}: uses logs and has no [plant] to simulate; name an experiment with a [plant]",
                                     arguments.experiment.experiment));
  if (!arguments.draw_parameters) experiment.plant->parameter_ranges.clear();
  const auto plant = make_plant(*experiment.plant);
  const Excitation excitation = parse_excitation(*plant, arguments.inputs);
  check_noise(noise, plant->outputs().size());
  if (is_stdout(arguments.output) && arguments.trajectories > 1)
    throw codegen::Error(
        fmt::format("-o -: stdout is a single file, but {} trajectories need one file each; write -o FILE.csv",
                    arguments.trajectories));
  for (int i = 0; i < arguments.trajectories; ++i)
    check_output_file(numbered_file(arguments.output, i, arguments.trajectories));
  run_phase([&] {
    const Dataset data = simulate_runs(experiment, *plant, initial_state_seed(arguments.seed, SeedStream::kTest),
                                       arguments.trajectories, 1.0, excitation);
    for (const std::string& warning : range_warnings(data, experiment))
      fmt::print(stderr, "warning: {}\n", printable(warning));
    for (int i = 0; i < arguments.trajectories; ++i) {
      MeasurementNoise sensor(noise, arguments.seed, static_cast<std::uint64_t>(i));
      const std::string file = numbered_file(arguments.output, i, arguments.trajectories);
      const Trajectory& run = data.trajectories[static_cast<std::size_t>(i)];
      write_output_file(file, csv(data, i, held(sensor.on(run.outputs))));
      if (!is_stdout(file)) fmt::print("{}: {} samples\n", file, run.samples());
    }
  });
}

}  // namespace

void add_simulate(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* command = app.add_subcommand("simulate", "Write trajectories of a plant as CSV logs");
  Options options(*command);
  options.value("EXPERIMENT", arguments->experiment.experiment, "experiment file, or the name of a shipped one")
      ->required();
  options
      .value("-o,--output", arguments->output,
             "CSV file, - for stdout; FILE_1.csv, FILE_2.csv... for several trajectories")
      ->required();
  options.number("--trajectories", arguments->trajectories, 1, kMostTrajectories,
                 "number of trajectories, each in its own file");
  options.shown("--noise", arguments->noise,
                "noise of the columns NAME_measured, in the format of nlo evaluate; or one noise for each output, "
                "separated by commas");
  options.repeated("--input", arguments->inputs,
                   "input u(t) of the plant, such as \"cos(12*t)\"; once for each of its inputs, in order", "EXPR");
  options.flag("--draw-parameters", arguments->draw_parameters,
               "draw parameters that have a range for each trajectory, as in training; otherwise each has the middle "
               "of its range");
  options.seed(arguments->seed, "seed of the initial states and the noise");
  options.changes(arguments->experiment.overrides);
  command->footer(
      "Columns: trajectory, time [s], each output, each output as measured, each state; with --input or [excitation] "
      "also each input. Angles are within half a turn of 0, as sensors show them.\n"
      "Examples:\n"
      "  nlo simulate van_der_pol --trajectories 8 --noise gaussian:0.1 -o logs/run.csv\n"
      "  nlo simulate van_der_pol --input \"cos(12*t)\" -o excited.csv\n"
      "  nlo simulate van_der_pol -o - | column -s, -t | less");
  command->callback([arguments, &action] { action = [arguments] { run_simulate(*arguments); }; });
}

}  // namespace nlo::trainer
