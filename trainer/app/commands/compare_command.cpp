// SPDX-License-Identifier: MIT
// nlo compare: observers against filters that know the plant, under many conditions.
#include <fmt/core.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>

#include "codegen/base/file.h"
#include "codegen/model_file/model_file.h"
#include "trainer/app/commands/command.h"
#include "trainer/app/commands/options.h"
#include "trainer/app/commands/output_directory.h"
#include "trainer/app/commands/patient_progress.h"
#include "trainer/app/jobs/run_jobs.h"
#include "trainer/app/report/pages.h"
#include "trainer/base/printable.h"
#include "trainer/data/dataset.h"
#include "trainer/judge/compare/compare_text.h"
#include "trainer/judge/compare/runs_under.h"
#include "trainer/judge/compare/study.h"

namespace nlo::trainer {
namespace {

struct CompareArguments {
  std::vector<std::string> models, changes;
  std::string conditions, output;
  StudyTest test;
  bool as_trained = false, quick = false, no_tuning = false, json = false;
};

std::vector<std::string> rivals() {
  std::vector<std::string> names = alternative_names();
  names.emplace_back(kParticle);
  return names;
}

/// All models must be of the plant and the box that the first was trained on: the same runs are to judge them.
void require_one_plant(const std::vector<NamedModel>& models, const std::vector<Experiment>& experiments) {
  const auto differs = [&](std::size_t i, const std::string& what) {
    throw codegen::Error(fmt::format("{}: has {} than {}; models are compared on the same runs of one plant",
                                     models[i].name, what, models.front().name));
  };
  const Experiment& first = experiments.front();
  for (std::size_t i = 1; i < models.size(); ++i) {
    const Experiment& other = experiments[i];
    if (other.plant->model != first.plant->model || other.plant->derivative != first.plant->derivative ||
        other.plant->outputs != first.plant->outputs || other.plant->input_field != first.plant->input_field)
      differs(i, "another plant");
    if (other.plant->parameters != first.plant->parameters) differs(i, "other nominal parameters");
    if (other.simulation.sample_period_s != first.simulation.sample_period_s) differs(i, "another sample period");
    if (channel_names(models[i].model.states) != channel_names(models.front().model.states) ||
        channel_names(models[i].model.outputs) != channel_names(models.front().model.outputs))
      differs(i, "other states or outputs");
  }
}

void run_compare(CompareArguments arguments) {
  std::vector<NamedModel> models;
  std::vector<Experiment> experiments;
  for (const std::string& path : arguments.models) {
    models.push_back({path, codegen::read_model(path)});
    experiments.push_back(experiment_of(models.back().model, path));
    if (!experiments.back().plant)
      throw codegen::Error(fmt::format(
          "{}: was trained on logs, so no equations are known that a filter could use; nlo identify finds some", path));
  }
  require_one_plant(models, experiments);
  if (arguments.test.against.empty()) arguments.test.against = rivals();
  arguments.test.tune = !arguments.no_tuning;
  if (arguments.quick) {
    arguments.test.test_sets = std::min(arguments.test.test_sets, 3);
    arguments.test.tuning_trajectories = std::min(arguments.test.tuning_trajectories, 6);
    arguments.test.particles = std::min(arguments.test.particles, 200);
  }
  ConditionSet set =
      arguments.as_trained
          ? ConditionSet{0.0, {trained_condition(experiments.front(), experiments.front().training.noise)}}
      : arguments.conditions.empty() ? default_conditions()
                                     : read_conditions(arguments.conditions);
  for (Condition& condition : set.conditions)
    condition.changes.insert(condition.changes.end(), arguments.changes.begin(), arguments.changes.end());
  std::vector<std::string> left_out;
  arguments.test.conditions = compared_conditions(experiments.front(), set, left_out);
  if (is_stdout(arguments.output))
    throw codegen::Error(
        "-o -: compare.html and compare.json are two files, and stdout is one; leave -o out: the result "
        "is on stdout, with --json in that form");
  if (!arguments.output.empty()) check_output_directory(arguments.output);

  const std::atomic<bool>& stop = stop_on_interrupt();
  PatientProgress progress;
  run_phase([&] {
    Study study = run_study(
        models, experiments.front(), arguments.test,
        [&](double share, const std::string& condition) { progress.update(share, condition); }, &stop);
    study.left_out = left_out;
    progress.finish();
    fmt::print("{}", arguments.json ? comparison_json(study) : printable(comparison_text(study)));
    if (arguments.output.empty()) return;
    make_output_directory(arguments.output);
    codegen::write_file_atomically(arguments.output + "/compare.json", comparison_json(study));
    codegen::write_file_atomically(arguments.output + "/compare.html", compare_page(study));
    if (!arguments.json) fmt::print("\ntable    {0}/compare.json\nreport   {0}/compare.html\n", arguments.output);
  });
}

}  // namespace

void add_compare(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<CompareArguments>();
  arguments->test.by_condition = true;
  arguments->test.test_sets = 20;
  arguments->test.trajectories = 5;
  CLI::App* command =
      app.add_subcommand("compare", "Observers against filters that know the plant, under many conditions");
  Options options(*command);
  options.value("MODEL", arguments->models, "model.json of nlo train, trained on a plant; several of one plant")
      ->required();
  options
      .list("--against", arguments->test.against,
            fmt::format("{} (all); particle knows each condition: the floor", fmt::join(rivals(), ", ")), "FILTER,...")
      ->check(CLI::IsMember(rivals()));
  CLI::Option* conditions = options.value(
      "--conditions", arguments->conditions,
      "[[condition]] tables: name, noise, parameters, parameter_factor, process_noise, box_scale, set, input, "
      "input_noise (twenty that fit any plant)",
      "FILE.toml");
  options
      .flag("--as-trained", arguments->as_trained, "one condition: noise and plant as in the first model's training")
      ->excludes(conditions);
  options.changes(arguments->changes,
                  "test on a changed plant in every condition: plant.KEY=VALUE, simulation.KEY=VALUE, "
                  "excitation.KEY=VALUE, feedback.KEY=VALUE; may be repeated; filters know the nominal one");
  options.number("--seeds", arguments->test.test_sets, 1, 10000, "test seeds, for means and standard errors");
  options.number("--trajectories", arguments->test.trajectories, 1, 100000, "runs for each seed");
  options.seed(arguments->test.seed, "first test seed");
  options.flag("--no-tuning", arguments->no_tuning, "only filters as shipped");
  options.number("--tuning-runs", arguments->test.tuning_trajectories, 1, 10000,
                 "runs of each condition to tune filters on");
  options.number("--particles", arguments->test.particles, 10, 1000000, "particles of the particle filter");
  options.flag("--quick", arguments->quick, "at most 3 seeds, 6 runs to tune on, 200 particles");
  options.threads(arguments->test.threads, "0: all cores; does not change the errors");
  options.directory("-o,--output", arguments->output, "directory for compare.html and compare.json");
  options.flag("--json", arguments->json, "one JSON object instead of the tables");
  command->footer(
      "Filters know the nominal plant and the nominal variance of the noise; tuned ones have Q, R, P0 and a gate on "
      "the\n"
      "innovation chosen for each condition on runs of its own.\n"
      "Examples:\n"
      "  nlo compare runs/van_der_pol/model.json -o runs/van_der_pol\n"
      "  nlo compare runs/a/model.json runs/b/model.json --against ekf,ukf --seeds 5\n"
      "  nlo compare runs/van_der_pol/model.json --conditions my_sensors.toml --no-tuning --json");
  command->callback([arguments, &action] { action = [arguments] { run_compare(*arguments); }; });
}

}  // namespace nlo::trainer
