// SPDX-License-Identifier: MIT
// nlo evaluate: tests a model on new trajectories of its plant or on logs, or compares it with filters under many
// conditions.
#include <fmt/core.h>
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/model_file/model_file.h"
#include "trainer/app/commands/command.h"
#include "trainer/app/commands/log_columns.h"
#include "trainer/app/commands/options.h"
#include "trainer/app/commands/output_directory.h"
#include "trainer/app/commands/patient_progress.h"
#include "trainer/app/commands/run_files.h"
#include "trainer/app/jobs/run_jobs.h"
#include "trainer/app/report/pages.h"
#include "trainer/base/printable.h"
#include "trainer/data/dataset.h"
#include "trainer/data/log_dataset.h"
#include "trainer/data/log_files.h"
#include "trainer/data/log_schema.h"
#include "trainer/data/training_logs.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/judge/compare/compare_text.h"
#include "trainer/judge/compare/runs_under.h"
#include "trainer/judge/compare/study.h"
#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/judge/evaluation/evaluate_logs.h"
#include "trainer/judge/evaluation/evaluation_text.h"
#include "trainer/plants/excitation.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/plant_registry.h"

namespace nlo::trainer {
namespace {

struct EvaluateArguments {
  std::vector<std::string> models, noise_words, data, missing;
  std::vector<double> from_s;
  std::string columns, input_noise = "none";
  LogFlight flight;
  RunFiles files;
  StudyTest test;
  Condition common;  ///< settings of the tests under all noises
  std::vector<NoiseConfig> noises;
  bool json = false;
  std::string plant_option;  ///< first given option that is only for plants

  std::string conditions, output;  ///< conditions: a file, or kShippedConditions
  bool as_trained = false, quick = false, no_tuning = false;
  std::string condition_option;  ///< first given option that is only for conditions
  bool gave_sets = false, gave_trajectories = false;

  bool by_condition() const { return as_trained || !conditions.empty(); }
};

constexpr const char* kShippedConditions = "default";

struct EvaluateOptions {
  std::vector<CLI::Option*> for_plants;                  ///< not allowed with --data
  std::vector<CLI::Option*> for_conditions;              ///< allowed only with --conditions and --as-trained
  CLI::Option *sets = nullptr, *trajectories = nullptr;  ///< their defaults depend on the test
};

/// Returns the values of --against.
std::vector<std::string> rivals() {
  std::vector<std::string> names = alternative_names();
  names.emplace_back(kTrueEkf);
  names.emplace_back(kParticle);
  return names;
}

/// Parsing fills `arguments`.
EvaluateOptions add_evaluate_options(CLI::App* command, EvaluateArguments& arguments) {
  Options options(*command);
  EvaluateOptions added;
  options
      .value("MODEL", arguments.models,
             "model.json of nlo train. Several models of one experiment give means over training seeds; with "
             "--conditions, several models of one plant give a column each")
      ->required();
  CLI::Option* conditions = options.value(
      "--conditions", arguments.conditions,
      "compare observers with filters that know the plant, as shipped and tuned, under several conditions. A file has "
      "[[condition]] tables with the keys name, noise, parameters, parameter_factor, process_noise, box_scale, set, "
      "input, input_noise; \"default\" means twenty conditions that suit any plant",
      "FILE.toml|default");
  CLI::Option* as_trained = options
                                .flag("--as-trained", arguments.as_trained,
                                      "compare under a single condition: noise and plant of the first model's training")
                                ->excludes(conditions);
  const auto without_conditions = [&](CLI::Option* option) {
    return option->excludes(conditions)->excludes(as_trained);
  };
  without_conditions(options.repeated(
      "--noise", arguments.noise_words,
      "noise of the outputs: none, gaussian:SIGMA, uniform:HALF_WIDTH or student:SCALE:FREEDOM, followed by any of "
      "+outliers:SHARE:AMPLITUDE, +bias:HALF_WIDTH, +common_bias:HALF_WIDTH, +clipped:LIMIT, +quantised:STEP, "
      "+delay:SAMPLES, +jitter:SHARE_OF_PERIOD, +missing:SHARE:SAMPLES_IN_A_ROW, +stuck:SHARE:SAMPLES_IN_A_ROW "
      "(repeats "
      "its last value) and +dead:SHARE:SAMPLES_IN_A_ROW (reads zero); or one for each output, separated by commas; may "
      "be repeated"));
  options.seed(arguments.test.seed, "seed of the initial states and the noise");
  added.sets = options.number("--seeds", arguments.test.test_sets, 1, 10000,
                              "number of test sets, from --seed on: means and standard errors; with --conditions: 20");
  added.trajectories = options.number("--trajectories", arguments.test.trajectories, 1, 100000,
                                      "new trajectories in a test set; with --conditions: 5");
  added.for_plants = {
      added.sets,
      without_conditions(options
                             .shown("--box-scale", arguments.common.box_scale,
                                    "factor for the size of the training box of initial states (circle: of its axes; "
                                    "list: of the distances from its mean)")
                             ->check(check_scale)),
      added.trajectories,
      without_conditions(options.repeated(
          "--input", arguments.common.inputs,
          "input u(t) of the plant, such as \"cos(12*t)\"; once for each of its inputs, in order (default: the "
          "experiment's [excitation])",
          "EXPR")),
      without_conditions(
          options
              .value("--input-noise", arguments.input_noise,
                     "noise of the inputs that the observer reads, in the form of --noise; the plant gets the inputs "
                     "without it",
                     "NOISE")
              ->allow_extra_args(false)),
      options.changes(arguments.common.changes,
                      "test on a changed plant: plant.KEY=VALUE, simulation.KEY=VALUE, excitation.KEY=VALUE, "
                      "feedback.KEY=VALUE; may be repeated"),
      options
          .list("--against", arguments.test.against,
                "estimators for comparison: ekf, ukf, mhe, high_gain (know the plant of the training), ekf_true (knows "
                "the changed plant), static_ridge (needs no plant); constant and ridge are always shown. Default with "
                "--conditions: all but ekf_true. particle knows each condition, so its error is the smallest possible")
          ->check(CLI::IsMember(rivals())),
      conditions,
      as_trained};
  added.for_conditions = {
      options.flag("--no-tuning", arguments.no_tuning, "with --conditions: only shipped filters, without tuning"),
      options.number("--tuning-runs", arguments.test.tuning_trajectories, 1, 10000,
                     "with --conditions: number of runs of each condition for the tuning of filters"),
      options.number("--particles", arguments.test.particles, 10, 1000000,
                     "with --conditions: number of particles of the particle filter"),
      options.flag("--quick", arguments.quick, "with --conditions: at most 3 test sets, 6 tuning runs, 200 particles"),
      options.directory("-o,--output", arguments.output,
                        "with --conditions: directory for compare.html and compare.json")};
  added.for_plants.insert(added.for_plants.end(), added.for_conditions.begin(), added.for_conditions.end());
  options.value("--data", arguments.data, "CSV logs (or globs) for the evaluation, instead of the plant");
  options.value(
      "--columns", arguments.columns,
      "roles of the logs' columns: a file with [[log.columns]] (default: the columns of the model's training, "
      "or headings that are the names of its outputs and states, and \"time\")",
      "FILE.toml");
  options.list("--from", arguments.from_s,
               "with --data: start of the observer after a log's first sample [s]; several: one start for each",
               "SECONDS");
  options.list(
      "--missing", arguments.missing,
      "with --data: an output that fails at the first sample, or SECONDS later: it is missing, repeats its last "
      "reading (stuck) or reads 0 (dead); several failures: repeat the option, or separate them by commas",
      "OUTPUT[:missing|stuck|dead[:SECONDS]]");
  options.flag("--behind-gate", arguments.flight.behind_gate,
               "with --data: the observer gets only the readings that the gate of its monitor accepts (nlo monitor)");
  options.value("--figure", arguments.files.figure,
                "with --data: a figure of each log with estimate, truth and error; times outside of the training "
                "domain are shaded; several logs or starts: FILE_1.svg, FILE_2.svg...",
                "FILE.svg");
  options.value("--estimates", arguments.files.estimates,
                "with --data: inputs and estimates of the observer for each sample; several logs or starts: "
                "FILE_1.csv, FILE_2.csv...",
                "FILE.csv");
  options.threads(arguments.test.threads, "number of threads; 0: all cores");
  options.flag("--json", arguments.json,
               "one JSON array instead of tables: an object for each noise; with --conditions one object");
  command->footer(
      "The observer is compared with a constant and with a ridge regression on its own features; on logs also with the "
      "sensor itself, polynomials, and a ridge regression on products of readings. These are fitted on the training "
      "logs if they are in the same folder. Otherwise they are fitted on the test logs themselves, which makes them "
      "too good.\nWith --conditions, filters know the nominal plant and the nominal variance of the noise. For tuned "
      "filters, Q, R, P0 and a gate on the innovation are chosen for each condition on separate runs.\nExamples:\n  "
      "nlo evaluate runs/van_der_pol/model.json --noise none --noise gaussian:0.5 --against ekf\n  nlo evaluate "
      "runs/s1/model.json runs/s2/model.json runs/s3/model.json --seeds 20 --noise gaussian:0.5\n  nlo evaluate "
      "runs/van_der_pol/model.json --set plant.parameters.mu=1.2 --against ekf,ekf_true\n  nlo evaluate "
      "runs/van_der_pol/model.json --noise uniform:3 --seed 7 --box-scale 2 --json\n  nlo evaluate "
      "runs/van_der_pol/model.json --input \"0.5*sin(2*t)\" --against ekf\n  nlo evaluate runs/qube/model.json --data "
      "logs/run8.csv logs/run9.csv\n  nlo evaluate runs/battery/model.json --data logs/cycle.csv --from 0,600,3000\n  "
      "nlo evaluate runs/car/model.json --data logs/run8.csv --missing wheel_speed\n  nlo evaluate runs/car/model.json "
      "--data logs/run8.csv --figure run8.svg --estimates run8_estimates.csv\n  nlo evaluate "
      "runs/van_der_pol/model.json --data bench.csv --columns bench.toml\n  nlo evaluate runs/van_der_pol/model.json "
      "--conditions default -o runs/van_der_pol\n  nlo evaluate runs/a/model.json runs/b/model.json --conditions "
      "default --against ekf,ukf --seeds 5\n  nlo evaluate runs/van_der_pol/model.json --conditions my_sensors.toml "
      "--no-tuning --json");
  return added;
}

void check_channels(const codegen::Model& model, std::size_t nx, std::size_t ny, const std::string& path) {
  if (model.states.size() == nx && model.outputs.size() == ny) return;
  throw codegen::Error(
      fmt::format("{}: has {} states and {} outputs, but its config describes {} and {}, so the file was changed; "
                  "train the model again",
                  path, model.states.size(), model.outputs.size(), nx, ny));
}

/// Throws unless models differ only in the seed, because standard errors over training seeds need that.
void require_one_experiment(const std::vector<NamedModel>& models) {
  std::string first;
  for (const NamedModel& model : models) {
    Experiment experiment = experiment_of(model.model, model.name);
    experiment.seed = 0;
    const std::string text = format_experiment(experiment);
    if (first.empty()) first = text;
    if (text != first)
      throw codegen::Error(
          fmt::format("{}: was trained by another experiment than {}, but several models may differ only in their "
                      "seed; evaluate them one by one, or compare them with --conditions default",
                      model.name, models.front().name));
  }
}

void print(const EvaluateArguments& arguments, const std::vector<std::string>& results) {
  if (arguments.json) return fmt::print("{}", json_array(results));
  for (const std::string& result : results)
    fmt::print("{}{}", &result == &results.front() ? "" : "\n", printable(result));
}

void check_input_noise(const EvaluateArguments& arguments, const std::vector<NamedModel>& models, const Plant& plant) {
  const NoiseConfig& noise = arguments.common.input_noise;
  if (noise.none()) return;
  for (const NamedModel& model : models)
    if (model.model.nu() == 0)
      throw codegen::Error(fmt::format(
          "--input-noise: the observer {} reads no inputs; leave the option out, or train with [excitation]",
          model.name));
  try {
    check_noise(noise, plant.inputs().size());
  } catch (const codegen::Error& error) {
    throw codegen::Error(
        fmt::format("--input-noise is not a noise for {} inputs: {}", plant.inputs().size(), error.what()));
  }
}

void on_plant(const EvaluateArguments& arguments, const std::vector<NamedModel>& models, const Experiment& experiment) {
  require_one_experiment(models);
  const Experiment tested = changed_experiment(experiment, arguments.common.changes);
  const auto plant = make_plant(*tested.plant);
  const PlantChannels channels(*tested.plant, *plant);
  for (const NamedModel& model : models)
    check_channels(model.model, channels.states().size(), channels.outputs().size(), model.name);
  for (const NoiseConfig& noise : arguments.noises) check_noise(noise, plant->outputs().size());
  check_input_noise(arguments, models, *plant);
  parse_excitation(*plant, arguments.common.inputs);  // reports wrong usage before anything runs
  const auto& against = arguments.test.against;
  if (arguments.common.changes.empty() && std::ranges::find(against, kTrueEkf) != against.end())
    throw codegen::Error(
        "--against ekf_true is only for a plant that --set changes; without --set, ekf already knows the true plant");
  const double scale = arguments.common.box_scale;
  const std::string note = scale == 1.0 ? "" : fmt::format("initial states from {} times the training box", scale);
  PatientProgress progress;
  const Study study = run_phase([&] {
    return run_study(models, experiment, arguments.test,
                     [&](double share, const std::string& what) { progress.update(share, what); });
  });
  progress.finish();
  std::vector<std::string> results;
  for (const StudyRow& row : study.rows)
    results.push_back(arguments.json ? evaluation_json(row, scale) : evaluation_text(row, note));
  print(arguments, results);
}

/// Throws unless all models were trained on the same plant and box, because they are evaluated on the same runs.
void require_one_plant(const std::vector<NamedModel>& models, const std::vector<Experiment>& experiments) {
  const auto differs = [&](std::size_t i, const std::string& what) {
    throw codegen::Error(fmt::format(
        "{}: has {} than {}, but models are compared on the same runs of one plant; compare models of one plant",
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

void on_conditions(EvaluateArguments& arguments, const std::vector<NamedModel>& models) {
  std::vector<Experiment> experiments;
  for (const NamedModel& model : models) {
    experiments.push_back(experiment_of(model.model, model.name));
    if (!experiments.back().plant)
      throw codegen::Error(
          fmt::format("{}: was trained on logs, so the filters have no equations; nlo identify can find them from logs",
                      model.name));
  }
  require_one_plant(models, experiments);
  const Experiment& first = experiments.front();
  StudyTest& test = arguments.test;
  if (std::ranges::find(test.against, kTrueEkf) != test.against.end())
    throw codegen::Error(
        "--against ekf_true cannot be used with --conditions; use joint_ekf, which estimates wrong parameters");
  test.by_condition = true;
  test.tune = !arguments.no_tuning;
  if (test.against.empty()) {
    test.against = alternative_names();
    test.against.emplace_back(kParticle);
  }
  if (!arguments.gave_sets) test.test_sets = 20;
  if (!arguments.gave_trajectories) test.trajectories = 5;
  if (arguments.quick) {
    test.test_sets = std::min(test.test_sets, 3);
    test.tuning_trajectories = std::min(test.tuning_trajectories, 6);
    test.particles = std::min(test.particles, 200);
  }
  ConditionSet set = arguments.as_trained ? ConditionSet{.conditions = {trained_condition(first, first.training.noise)}}
                     : arguments.conditions == kShippedConditions ? default_conditions()
                                                                  : read_conditions(arguments.conditions);
  const std::vector<std::string>& changes = arguments.common.changes;
  for (Condition& condition : set.conditions)
    condition.changes.insert(condition.changes.end(), changes.begin(), changes.end());
  std::vector<std::string> left_out;
  test.conditions = compared_conditions(first, set, left_out);
  test.leave_out_impossible = set.written_for_deviation > 0.0;
  if (is_stdout(arguments.output))
    throw codegen::Error(
        "-o -: compare.html and compare.json are two files, but stdout is one; without -o the result goes to stdout "
        "(with --json as JSON)");
  if (!arguments.output.empty()) check_output_directory(arguments.output);

  const std::atomic<bool>& stop = stop_on_interrupt();
  PatientProgress progress;
  run_phase([&] {
    Study study = run_study(
        models, first, test, [&](double share, const std::string& condition) { progress.update(share, condition); },
        &stop);
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

/// Adds notes on logs with which the model was trained. A model of an older version has no record of its logs and gets
/// no note.
void note_training_logs(const codegen::Model& model, const Dataset& logs, LogReport& report) {
  for (const auto& [name, fact] : model.provenance) {
    if (name != kTrainingLogsFact) continue;
    const TrainingLogs training = parse_training_logs(fact);
    note_rows_of_training(training, report.contents, report.notes);
    note_outputs_beyond(training, logs, report.notes);
  }
}

void on_logs(const EvaluateArguments& arguments, const std::vector<NamedModel>& models, const Experiment& experiment) {
  PatientProgress progress;
  std::vector<std::string> unit_notes;
  LogConfig columns = columns_for(models.front().model, experiment, arguments.columns, unit_notes);
  // Uses the period of the model, so that a log with another rate does not count as regular.
  columns.sample_period_s = models.front().model.sample_period_s;
  if (arguments.columns.empty()) {
    const LogSchema all = resolve_columns(columns);
    for (const NamedModel& model : models)
      check_channels(model.model, all.state_channels.size(), all.output_channels.size(), model.name);
  }
  leave_out_absent_truth(columns, arguments.data);
  const LogSchema schema = resolve_columns(columns);
  for (const NoiseConfig& noise : arguments.noises) check_noise(noise, schema.outputs.size());
  progress.update(0.0, "reading the logs");
  LogReport report;
  Dataset logs = load_logs(columns, "", arguments.data, &report);
  report.notes.insert(report.notes.begin(), unit_notes.begin(), unit_notes.end());
  if (!arguments.from_s.empty()) logs = started_at(logs, arguments.from_s);
  const std::optional<Dataset> training =
      training_logs_beside(models.front().model, experiment, columns, arguments.data);
  const MetricsConfig config = metrics_config(experiment, logs);
  std::vector<std::string> results;
  const auto all = static_cast<double>(models.size() * arguments.noises.size());
  for (const NamedModel& model : models) {
    LogReport found = report;
    note_training_logs(model.model, logs, found);
    for (const NoiseConfig& noise : arguments.noises) {
      const auto done = static_cast<double>(results.size());
      LogEvaluation evaluation = run_phase([&] {
        return evaluate_on_logs(
            model.model, logs, schema, training ? &*training : nullptr, noise, arguments.test.seed, config,
            [&](double share, const std::string& what) { progress.update((done + share) / all, what); },
            arguments.flight);
      });
      evaluation.notes.insert(evaluation.notes.end(), found.notes.begin(), found.notes.end());
      results.push_back(arguments.json ? evaluation_json(model.name, evaluation)
                                       : evaluation_text(model.name, evaluation));
      if (!arguments.files.any()) continue;
      progress.finish();
      run_phase(
          [&] { write_run_files(arguments.files, model.model, evaluation, has_uniform_steps(logs, model.model)); });
    }
  }
  progress.finish();
  print(arguments, results);
}

void run_evaluate(EvaluateArguments arguments) {
  for (const std::string& noise : arguments.noise_words) arguments.noises.push_back(parse_noise(noise));
  if (arguments.noise_words.empty()) arguments.noises.emplace_back();
  arguments.common.input_noise = parse_noise(arguments.input_noise);
  arguments.test.conditions = conditions_of(arguments.noises, arguments.common);
  std::vector<NamedModel> models;
  for (const std::string& path : arguments.models) models.push_back({path, codegen::read_model(path)});
  const std::string& first = arguments.models.front();
  const Experiment experiment = experiment_of(models.front().model, first);
  const auto refuse = [&](const std::string& what) { throw codegen::Error(fmt::format("{}: {}", first, what)); };
  if (arguments.data.empty()) {
    if (!experiment.plant && !arguments.by_condition())
      refuse("was trained on logs; name the logs for the evaluation: --data FILE...");
    if (!arguments.from_s.empty()) refuse("--from needs logs; add --data FILE...");
    if (!arguments.missing.empty()) refuse("--missing needs logs; add --data FILE...");
    if (arguments.flight.behind_gate) refuse("--behind-gate needs logs; add --data FILE...");
    if (arguments.files.any()) refuse("--figure and --estimates need logs; add --data FILE...");
    if (!arguments.columns.empty()) refuse("--columns needs logs; add --data FILE...");
    if (arguments.by_condition()) return on_conditions(arguments, models);
    if (!arguments.condition_option.empty())
      throw codegen::Error(
          fmt::format("{} needs a test under conditions; add --conditions FILE or --conditions default",
                      arguments.condition_option));
    if (std::ranges::find(arguments.test.against, kParticle) != arguments.test.against.end())
      throw codegen::Error(
          "--against particle needs conditions, because the particle filter knows each of them; add --conditions FILE "
          "or --conditions default");
    on_plant(arguments, models, experiment);
  } else {
    for (const std::string& word : arguments.missing) arguments.flight.faults.push_back(parse_fault(word));
    for (const NamedModel& model : models)
      if (arguments.flight.behind_gate && !model.model.monitor)
        throw codegen::Error(fmt::format("--behind-gate: {} has no monitor; add one with nlo monitor", model.name));
    if (!arguments.plant_option.empty())
      refuse(
          fmt::format("{} is only for simulated trajectories of a plant; logs are evaluated unchanged and with all "
                      "alternatives: leave the option out",
                      arguments.plant_option));
    if (arguments.files.any() && (models.size() > 1 || arguments.noises.size() > 1))
      refuse("--figure and --estimates need exactly one model and one --noise");
    check_run_files(arguments.files);
    on_logs(arguments, models, experiment);
  }
}

/// Sets the work of the command. `action` calls `before` with the arguments and then runs the command.
void set_up(CLI::App* command, Action& action, const std::function<void(EvaluateArguments&)>& before) {
  auto arguments = std::make_shared<EvaluateArguments>();
  const EvaluateOptions options = add_evaluate_options(command, *arguments);
  command->callback([arguments, &action, options, before] {
    const auto first_of = [](const std::vector<CLI::Option*>& group) {
      const auto given = std::ranges::find_if(group, [](const CLI::Option* option) { return option->count() > 0; });
      return given == group.end() ? "" : (*given)->get_name();
    };
    arguments->plant_option = first_of(options.for_plants);
    arguments->condition_option = first_of(options.for_conditions);
    arguments->gave_sets = options.sets->count() > 0;
    arguments->gave_trajectories = options.trajectories->count() > 0;
    action = [arguments, before] {
      before(*arguments);
      run_evaluate(*arguments);
    };
  });
}

}  // namespace

void add_evaluate(CLI::App& app, Action& action) {
  set_up(app.add_subcommand("evaluate", "Measure the errors of a model, and compare it with filters"), action,
         [](EvaluateArguments&) {});
}

void add_compare(CLI::App& app, Action& action) {
  set_up(app.add_subcommand("compare", "Old name of nlo evaluate --conditions default"), action,
         [](EvaluateArguments& arguments) {
           fmt::print(stderr,
                      "note: nlo compare is now nlo evaluate --conditions default; the next version has no compare\n");
           if (!arguments.by_condition()) arguments.conditions = kShippedConditions;
         });
}

}  // namespace nlo::trainer
