// SPDX-License-Identifier: MIT
#include "trainer/commands/strict_test.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>

#include "codegen/base/error.h"
#include "trainer/base/nearest_name.h"
#include "trainer/compare/table_filter.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/evaluation/closed_loop.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/plants/drawn_inputs.h"
#include "trainer/plants/loop_estimator.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/registry.h"
#include "trainer/plants/simulate.h"
#include "trainer/plants/simulate_runs.h"

namespace nlo::trainer {
namespace {

constexpr std::string_view kStaticRidge = "static_ridge";

/// Whether inputs stay as they are between samples: a u(t) of the command line is smooth, what is drawn may be held.
bool held_inputs(const Experiment& experiment, const StrictTest& test) {
  return experiment.moves_inputs() && test.inputs.empty() && experiment.observer.input_hold == Hold::kZeroOrder;
}

/// The inputs as estimators are told them. What does not arrive is held, as in flight.
void disturb_inputs(const NoiseConfig& noise, std::uint64_t seed, Dataset& runs) {
  if (noise.none()) return;
  constexpr std::uint64_t kOfInputs = 0x696e70757473ULL;  // no numbers in common with the outputs' noise
  for (std::size_t i = 0; i < runs.trajectories.size(); ++i) {
    Eigen::MatrixXd& inputs = runs.trajectories[i].inputs;
    inputs = held(MeasurementNoise(noise, seed ^ kOfInputs, i).on(inputs));
  }
}

/// What the constant and the readout learn from: runs of the training's own distribution.
Dataset fresh_training_runs(const Experiment& experiment) {
  constexpr int kEnough = 100;  // 250,000 samples of the shipped plants for some ten coefficients
  const auto plant = make_plant(*experiment.plant);
  Dataset runs = simulate_runs(experiment, *plant, initial_state_seed(experiment.seed, SeedStream::kTraining),
                               std::min(experiment.simulation.trajectories, kEnough));
  PlantChannels(*experiment.plant, *plant).apply(runs);
  return runs;
}

/// Runs one strict study; what does not depend on the test set is made once.
class Study {
 public:
  Study(const std::vector<NamedModel>& models, const Experiment& experiment, const StrictTest& test)
      : models_(models),
        nominal_(experiment),
        tested_(changed_experiment(experiment, test.changes)),
        test_(test),
        plant_(make_plant(*tested_.plant)),
        config_(metrics_config(tested_, tested_.simulation.horizon_s)),
        training_(fresh_training_runs(experiment)) {
    if (tested_.feedback)
      tested_.feedback->error.clear();  // the loop of the true state is what others are held against
    disturb_inputs(test.input_noise, initial_state_seed(experiment.seed, SeedStream::kTraining), training_);
  }

  std::vector<EvaluationStudy> run(const StudyProgress& progress) {
    std::vector<EvaluationStudy> studies(test_.noises.size());
    for (EvaluationStudy& study : studies) {
      for (const NamedModel& model : models_) study.models.push_back(model.name);
      study.results.resize(models_.size());
    }
    // The same noise in another order of runs than a test set's: seeded by what no user's seed is.
    const std::uint64_t noise_seed = initial_state_seed(nominal_.seed, SeedStream::kTraining);
    std::vector<std::vector<EstimatorFactory>> readouts(test_.noises.size());
    std::vector<EstimatorFactory> static_ridges(test_.noises.size());
    for (std::size_t n = 0; n < test_.noises.size(); ++n) {
      const Dataset noisy = with_noise(training_, test_.noises[n], noise_seed);
      for (const NamedModel& model : models_) readouts[n].push_back(readout_estimator(model.model, noisy));
      if (std::ranges::find(test_.against, kStaticRidge) != test_.against.end())
        static_ridges[n] = baseline_estimator(kStaticRidge, noisy);
    }

    const auto sets = static_cast<std::size_t>(test_.test_sets);
    for (std::size_t s = 0; s < sets; ++s) {
      const std::uint64_t seed = test_.seed + s;
      Dataset set = simulate_runs(tested_, *plant_, initial_state_seed(seed, SeedStream::kTest), test_.trajectories,
                                  test_.box_scale, parse_excitation(*plant_, test_.inputs));
      const std::optional<double> cost = looped() ? mean_cost(tested_, *plant_, set) : std::nullopt;
      PlantChannels(*tested_.plant, *plant_).apply(set);
      disturb_inputs(test_.input_noise, seed, set);
      for (std::size_t n = 0; n < test_.noises.size(); ++n) {
        const NoiseConfig& noise = test_.noises[n];
        const std::vector<Evaluation> shared = alternatives(set, noise, seed, static_ridges[n]);
        for (std::size_t m = 0; m < models_.size(); ++m) {
          std::vector<Evaluation>& group = studies[n].results[m].emplace_back();
          group.push_back(evaluate_on_plant(models_[m].model, set, noise, seed, test_.threads, config_));
          group.insert(group.end(), shared.begin(), shared.end());
          group.push_back(judged("ridge", readouts[n][m], set, noise, seed));
          if (looped()) add_loops(models_[m].model, {set, cost}, noise, seed, group);
          for (Evaluation& evaluation : group) {
            evaluation.excitation = tested_.excitation && test_.inputs.empty()
                                        ? describe_inputs(*tested_.excitation, *plant_)
                                        : name_expressions(*plant_, test_.inputs);
            if (!test_.input_noise.none())
              for (std::size_t j = 0; j < evaluation.excitation.size(); ++j)
                evaluation.excitation[j].second += fmt::format(", told with {}", sensor_title(test_.input_noise.of(j)));
            evaluation.changed = fmt::format("{}", fmt::join(test_.changes, ", "));
          }
          if (progress)
            progress((static_cast<double>((s * test_.noises.size() + n) * models_.size() + m) + 1.0) /
                     static_cast<double>(sets * test_.noises.size() * models_.size()));
        }
      }
    }
    for (EvaluationStudy& study : studies) {
      if (!study.is_single()) continue;
      std::vector<std::string>& notes = study.results.front().front().front().notes;
      notes = study_notes(study);
    }
    return studies;
  }

 private:
  bool looped() const { return tested_.feedback && tested_.feedback->share > 0.0 && test_.inputs.empty(); }

  /// The loop of the true state.
  struct IdealLoop {
    const Dataset& set;
    std::optional<double> cost;  ///< mean_cost() of it
  };

  /// Estimators where their own estimates close the loop, through the noise; the same starts and references.
  void add_loops(const codegen::Model& model, const IdealLoop& ideal, const NoiseConfig& noise, std::uint64_t seed,
                 std::vector<Evaluation>& group) const {
    const NoiseConfig in_loop = without_shifts(noise);
    const auto add = [&](const std::string& name, const LoopEstimators& estimators, auto&& judge) {
      Dataset set = simulate_runs(tested_, *plant_, initial_state_seed(seed, SeedStream::kTest), test_.trajectories,
                                  test_.box_scale, {}, with_noise(estimators, in_loop, seed));
      const std::optional<double> cost = mean_cost(tested_, *plant_, set);  // of all states, estimated or not
      PlantChannels(*tested_.plant, *plant_).apply(set);
      Evaluation evaluation = judge(set);
      evaluation.estimator = name + "_in_loop";
      evaluation.label = name + " in its own loop";
      evaluation.loop = closed_loop_cost(ideal.set, set);
      evaluation.loop->cost = cost;
      evaluation.loop->of_true_state = ideal.cost;
      group.push_back(std::move(evaluation));
    };
    add("observer", observer_in_loop(model, tested_, *plant_),
        [&](const Dataset& set) { return evaluate_on_plant(model, set, in_loop, seed, test_.threads, config_); });
    for (const std::string& name : test_.against)
      if (find_filter(name) != nullptr)
        add(name, filter_in_loop(name, nominal_, in_loop),
            [&](const Dataset& set) { return judged(name, filter(name, in_loop), set, in_loop, seed); });
  }

  /// ekf_true is the EKF that knows what --set changed.
  const Experiment& known_to(const std::string& name) const { return name == kTrueEkf ? tested_ : nominal_; }
  static std::string_view row_of(const std::string& name) { return name == kTrueEkf ? "ekf" : std::string_view(name); }

  EstimatorFactory filter(const std::string& name, const NoiseConfig& noise) const {
    const bool beside_one_that_knows_its_errors =
        std::ranges::any_of(models_, [](const NamedModel& m) { return m.model.error.has_value(); });
    return table_filter(row_of(name), known_to(name), noise, held_inputs(tested_, test_),
                        beside_one_that_knows_its_errors);
  }

  Evaluation judged(const std::string& name, const EstimatorFactory& estimator, const Dataset& set,
                    const NoiseConfig& noise, std::uint64_t seed) const {
    return evaluate(name, estimator, set, noise, seed, test_.threads, config_);
  }

  /// Those that know nothing of the models.
  std::vector<Evaluation> alternatives(const Dataset& set, const NoiseConfig& noise, std::uint64_t seed,
                                       const EstimatorFactory& static_ridge) const {
    const bool changed = !test_.changes.empty();
    std::vector<Evaluation> result;
    for (const std::string& name : test_.against) {
      if (name == "constant" || name == "ridge") continue;  // always there
      const bool knows_no_plant = name == kStaticRidge;
      result.push_back(judged(name, knows_no_plant ? static_ridge : filter(name, noise), set, noise, seed));
      if (changed && !knows_no_plant)
        result.back().label = fmt::format("{}, {} parameters", row_of(name), name == kTrueEkf ? "true" : "nominal");
    }
    result.push_back(judged("constant", baseline_estimator("constant", training_), set, noise, seed));
    return result;
  }

  const std::vector<NamedModel>& models_;
  const Experiment& nominal_;
  Experiment tested_;
  const StrictTest& test_;
  std::unique_ptr<Plant> plant_;
  MetricsConfig config_;
  Dataset training_;
};

}  // namespace

Experiment experiment_of(const codegen::Model& model, const std::string& origin) {
  for (const auto& [key, text] : model.provenance)
    if (key == "config") return parse_experiment(text, origin + " (provenance.config)");
  throw codegen::Error(
      fmt::format("{}: has no provenance \"config\", so plant and columns are not known; train it again", origin));
}

Experiment changed_experiment(const Experiment& experiment, const std::vector<std::string>& changes) {
  if (changes.empty()) return experiment;
  for (const std::string& change : changes) {
    const std::string key = change.substr(0, change.find('='));
    if (!key.starts_with("plant.") && !key.starts_with("simulation.") && !key.starts_with("excitation.") &&
        !key.starts_with("feedback."))
      throw codegen::Error(
          fmt::format("--set {}: only plant.KEY, simulation.KEY, excitation.KEY and feedback.KEY can be changed for a "
                      "test; the model "
                      "is what it was trained to be",
                      change));
    const std::string parameter = "plant.parameters.";
    if (!key.starts_with(parameter) || !experiment.plant->model.empty()) continue;  // a built-in plant knows its own
    std::vector<std::string> names;
    for (const auto& known : experiment.plant->parameters) names.push_back(known.first);
    const std::string name = key.substr(parameter.size());
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    const std::string nearest = nearest_name(name, names);
    throw codegen::Error(fmt::format("--set {}: the plant has no parameter \"{}\"; {}", change, name,
                                     names.empty()     ? "it has none: write its numbers as parameters"
                                     : nearest.empty() ? fmt::format("there are: {}", fmt::join(names, ", "))
                                                       : fmt::format("did you mean \"{}\"?", nearest)));
  }
  // Training is over: what it asks of a plant (mirror images, a past without inputs) is not asked of a test.
  std::vector<std::string> all = changes;
  all.insert(all.end(), {"training.mirror=false", "training.transient=keep"});
  return parse_experiment(experiment.source_text, "the model's experiment", all);
}

std::vector<std::string> alternative_names() {
  std::vector<std::string> names = filter_names();
  names.insert(names.end(), {"static_ridge", "constant", "ridge"});
  return names;
}

std::vector<EvaluationStudy> run_strict_study(const std::vector<NamedModel>& models, const Experiment& experiment,
                                              const StrictTest& test, const StudyProgress& progress) {
  return Study(models, experiment, test).run(progress);
}

std::vector<std::vector<Evaluation>> run_strict_test(const codegen::Model& model, const Experiment& experiment,
                                                     const StrictTest& test) {
  StrictTest once = test;
  once.test_sets = 1;
  std::vector<std::vector<Evaluation>> result;
  for (EvaluationStudy& study : run_strict_study({{model.name, model}}, experiment, once))
    result.push_back(std::move(study.results.front().front()));
  return result;
}

}  // namespace nlo::trainer
