// SPDX-License-Identifier: MIT
// nlo evaluate: a model on new trajectories of its plant, or on logs it was not trained on.
#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "codegen/model_file.h"
#include "trainer/analysis/evaluate_logs.h"
#include "trainer/analysis/evaluation_text.h"
#include "trainer/commands/command.h"
#include "trainer/commands/strict_test.h"
#include "trainer/data/log_dataset.h"
#include "trainer/data/log_schema.h"
#include "trainer/data/training_logs.h"
#include "trainer/plants/excitation.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/registry.h"

namespace nlo::trainer {
namespace {

struct Arguments {
  std::string model;
  std::vector<std::string> noises, data;
  StrictTest test;
  bool json = false;
  bool plant_options_given = false;  ///< --box-scale, --trajectories or --input
};

void check_channels(const codegen::Model& model, std::size_t nx, std::size_t ny, const std::string& path) {
  if (model.states.size() == nx && model.outputs.size() == ny) return;
  throw codegen::Error(
      fmt::format("{}: has {} states and {} outputs, but its config describes {} and {}; the file was "
                  "changed: train it again",
                  path, model.states.size(), model.outputs.size(), nx, ny));
}

void on_plant(const Arguments& arguments, const codegen::Model& model, const Experiment& experiment) {
  const auto plant = make_plant(*experiment.plant);
  const PlantChannels channels(*experiment.plant, *plant);
  check_channels(model, channels.states().size(), channels.outputs().size(), arguments.model);
  for (const NoiseConfig& noise : arguments.test.noises) check_noise(noise, plant->outputs().size());
  parse_excitation(*plant, arguments.test.inputs);  // wrong usage is said before anything runs
  const double scale = arguments.test.box_scale;
  const std::string note = scale == 1.0 ? "" : fmt::format("initial states from {} times the training box", scale);
  for (const auto& evaluations : run_phase([&] { return run_strict_test(model, experiment, arguments.test); }))
    fmt::print("{}", arguments.json ? evaluation_json(arguments.model, evaluations, scale)
                                    : evaluation_text(arguments.model, evaluations, note));
}

/// A model of an older version does not remember its logs: nothing is said then.
void note_training_logs(const codegen::Model& model, const Dataset& logs, LogReport& report) {
  for (const auto& [name, fact] : model.provenance) {
    if (name != kTrainingLogsFact) continue;
    const TrainingLogs training = parse_training_logs(fact);
    note_rows_of_training(training, report.contents, report.notes);
    note_outputs_beyond(training, logs, report.notes);
  }
}

void on_logs(const Arguments& arguments, const codegen::Model& model, const Experiment& experiment) {
  const LogSchema schema = resolve_columns(*experiment.log);
  check_channels(model, schema.state_channels.size(), schema.output_channels.size(), arguments.model);
  for (const NoiseConfig& noise : arguments.test.noises) check_noise(noise, schema.outputs.size());
  LogReport report;
  const Dataset logs = load_logs(*experiment.log, "", arguments.data, &report);
  note_training_logs(model, logs, report);
  for (const NoiseConfig& noise : arguments.test.noises) {
    LogEvaluation evaluation =
        run_phase([&] { return evaluate_on_logs(model, logs, schema, nullptr, noise, arguments.test.seed); });
    evaluation.notes.insert(evaluation.notes.end(), report.notes.begin(), report.notes.end());
    fmt::print("{}", arguments.json ? evaluation_json(arguments.model, evaluation)
                                    : evaluation_text(arguments.model, evaluation));
  }
}

void run(Arguments arguments) {
  for (const std::string& noise : arguments.noises) arguments.test.noises.push_back(parse_noise(noise));
  if (arguments.noises.empty()) arguments.test.noises.emplace_back();
  const codegen::Model model = codegen::read_model(arguments.model);
  const Experiment experiment = experiment_of(model, arguments.model);
  const auto refuse = [&](const char* what) { throw codegen::Error(fmt::format("{}: {}", arguments.model, what)); };
  if (experiment.plant) {
    if (!arguments.data.empty())
      refuse("was trained on a plant, whose config names no columns of logs; evaluate it without --data");
    on_plant(arguments, model, experiment);
  } else {
    if (arguments.data.empty()) refuse("was trained on logs; name the logs to evaluate it on: --data FILE...");
    if (arguments.plant_options_given)
      refuse(
          "was trained on logs; --box-scale, --trajectories and --input are for plants, logs are evaluated as they "
          "are");
    if (!arguments.test.against.empty())
      refuse("was trained on logs; --against is for plants, on logs the alternatives are always shown");
    on_logs(arguments, model, experiment);
  }
}

}  // namespace

void add_evaluate(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("evaluate", "Measure how well a model estimates the state");
  command->add_option("MODEL", arguments->model, "model.json of nlo train")->required();
  command
      ->add_option(
          "--noise", arguments->noises,
          "on the outputs: none, gaussian:SIGMA, uniform:HALF_WIDTH, or one for each output with commas between; may "
          "be repeated")
      ->allow_extra_args(false);
  command->add_option("--seed", arguments->test.seed, "of the initial states and the noise")
      ->check(check_seed)
      ->capture_default_str();
  CLI::Option* box =
      command
          ->add_option("--box-scale", arguments->test.box_scale,
                       "initial states from the training box times this (circle: its axes; list: about its mean)")
          ->check(check_scale)
          ->capture_default_str();
  CLI::Option* count = command->add_option("--trajectories", arguments->test.trajectories, "how many new trajectories")
                           ->check(CLI::Range(1, 100000))
                           ->capture_default_str();
  CLI::Option* input =
      command
          ->add_option("--input", arguments->test.inputs,
                       "excite the plant: u(t), as \"cos(12*t)\"; once for each of its inputs, in order")
          ->allow_extra_args(false)
          ->type_name("EXPR");
  command->add_option("--data", arguments->data, "CSV logs (or globs) to evaluate on, for a model trained on logs");
  command->add_option("--against", arguments->test.against, "alternatives: ekf (knows the plant exactly), constant")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember({"ekf", "constant"}));
  command->add_option("--threads", arguments->test.threads, "0: all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "one JSON object per noise instead of tables");
  command->footer(
      "Examples:\n"
      "  nlo evaluate runs/van_der_pol/model.json --noise none --noise gaussian:0.5 --against ekf\n"
      "  nlo evaluate runs/van_der_pol/model.json --noise uniform:3 --seed 7 --box-scale 2 --json\n"
      "  nlo evaluate runs/van_der_pol/model.json --input \"0.5*sin(2*t)\" --against ekf\n"
      "  nlo evaluate runs/qube/model.json --data logs/run8.csv logs/run9.csv");
  command->callback([arguments, &action, box, count, input] {
    arguments->plant_options_given = box->count() + count->count() + input->count() > 0;
    action = [arguments] { run(*arguments); };
  });
}

}  // namespace nlo::trainer
