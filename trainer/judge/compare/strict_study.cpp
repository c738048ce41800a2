// SPDX-License-Identifier: MIT
#include "trainer/judge/compare/strict_study.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <memory>

#include "codegen/base/error.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/judge/compare/runs_under.h"
#include "trainer/judge/compare/table_filter.h"
#include "trainer/judge/evaluation/closed_loop.h"
#include "trainer/judge/evaluation/estimator_words.h"
#include "trainer/plants/drawn_inputs.h"
#include "trainer/plants/loop_estimator.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/plant_registry.h"

namespace nlo::trainer {
namespace {

using Models = std::vector<NamedModel>;

/// One condition; what does not depend on the test set is made once.
class Row {
 public:
  Row(const Models& models, const Experiment& experiment, const StrictTest& test, const Condition& condition)
      : models_(models),
        nominal_(experiment),
        tested_(changed_experiment(experiment, condition.changes)),
        test_(test),
        condition_(condition),
        plant_(make_plant(*tested_.plant)),
        config_(metrics_config(tested_, tested_.simulation.horizon_s)),
        training_(fresh_training_runs(experiment, condition.input_noise)) {
    if (tested_.feedback)
      tested_.feedback->error.clear();  // the loop of the true state is what others are held against
    const Dataset noisy = with_noise(training_, condition.noise, fresh_noise_seed(experiment));
    for (const NamedModel& model : models) readouts_.push_back(simple_estimator("ridge", model.model, noisy));
    constant_ = simple_estimator("constant", models.front().model, noisy);
    for (const std::string& name : test.against)
      others_.push_back(is_always_there(name) ? nullptr
                        : knows_plant(name)   ? filter(name, condition.noise)
                                              : simple_estimator(name, models.front().model, noisy));
  }

  EvaluationStudy run(const StudyProgress& progress) {
    EvaluationStudy study;
    for (const NamedModel& model : models_) study.models.push_back(model.name);
    study.results.resize(models_.size());
    const int sets = test_.test_sets;
    for (int s = 0; s < sets; ++s) {
      const std::uint64_t seed = test_.seed + static_cast<unsigned>(s);
      Dataset set =
          runs_under(tested_, condition_, initial_state_seed(seed, SeedStream::kTest), test_.trajectories, first(s));
      const std::optional<double> cost = looped() ? mean_cost(tested_, *plant_, set) : std::nullopt;
      PlantChannels(*tested_.plant, *plant_).apply(set);
      disturb_inputs(condition_.input_noise, seed, set);
      const std::vector<Evaluation> shared = alternatives(set, seed);
      for (std::size_t m = 0; m < models_.size(); ++m) {
        std::vector<Evaluation>& group = study.results[m].emplace_back();
        group.push_back(evaluate_on_plant(models_[m].model, set, condition_.noise, seed, test_.threads, config_));
        group.insert(group.end(), shared.begin(), shared.end());
        group.push_back(judged("ridge", readouts_[m], set, condition_.noise, seed));
        if (looped()) add_loops(models_[m].model, {set, cost}, s, seed, group);
        for (Evaluation& evaluation : group) describe(evaluation);
        if (progress)
          progress((s + static_cast<double>(m + 1) / static_cast<double>(models_.size())) / static_cast<double>(sets),
                   "test sets");
      }
    }
    if (study.is_single()) {
      std::vector<std::string>& notes = study.results.front().front().front().notes;
      notes = study_notes(study);
    }
    return study;
  }

 private:
  bool looped() const { return tested_.feedback && tested_.feedback->share > 0.0 && condition_.inputs.empty(); }

  /// The number of a set's first run.
  std::size_t first(int set) const {
    return static_cast<std::size_t>(set) * static_cast<std::size_t>(test_.trajectories);
  }

  void describe(Evaluation& evaluation) const {
    evaluation.excitation = tested_.excitation && condition_.inputs.empty()
                                ? describe_inputs(*tested_.excitation, *plant_)
                                : name_expressions(*plant_, condition_.inputs);
    if (!condition_.input_noise.none())
      for (std::size_t j = 0; j < evaluation.excitation.size(); ++j)
        evaluation.excitation[j].second += fmt::format(", told with {}", sensor_title(condition_.input_noise.of(j)));
    evaluation.changed = fmt::format("{}", fmt::join(condition_.changes, ", "));
  }

  /// The loop of the true state.
  struct IdealLoop {
    const Dataset& set;
    std::optional<double> cost;  ///< mean_cost() of it
  };

  /// Estimators where their own estimates close the loop, through the noise; the same starts and references.
  void add_loops(const codegen::Model& model, const IdealLoop& ideal, int number, std::uint64_t seed,
                 std::vector<Evaluation>& group) const {
    const NoiseConfig in_loop = without_shifts(condition_.noise);
    const auto add = [&](const std::string& name, const LoopEstimators& estimators, auto&& judge) {
      Dataset set = runs_under(tested_, condition_, initial_state_seed(seed, SeedStream::kTest), test_.trajectories,
                               first(number), with_noise(estimators, in_loop, seed));
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

  static bool is_always_there(const std::string& name) { return name == "constant" || name == "ridge"; }
  static bool knows_plant(const std::string& name) { return estimator_words(name)->knows_plant; }

  /// ekf_true is the EKF that knows what --set changed.
  const Experiment& known_to(const std::string& name) const { return name == kTrueEkf ? tested_ : nominal_; }
  static std::string_view row_of(const std::string& name) { return name == kTrueEkf ? "ekf" : std::string_view(name); }

  EstimatorFactory filter(const std::string& name, const NoiseConfig& noise) const {
    const bool beside_one_that_knows_its_errors =
        std::ranges::any_of(models_, [](const NamedModel& m) { return m.model.error.has_value(); });
    return table_filter(row_of(name), known_to(name), noise, holds_inputs(tested_, condition_),
                        beside_one_that_knows_its_errors);
  }

  Evaluation judged(const std::string& name, const EstimatorFactory& estimator, const Dataset& set,
                    const NoiseConfig& noise, std::uint64_t seed) const {
    return evaluate(name, estimator, set, noise, seed, test_.threads, config_);
  }

  /// Those that know nothing of the models.
  std::vector<Evaluation> alternatives(const Dataset& set, std::uint64_t seed) const {
    const bool changed = !condition_.changes.empty();
    const NoiseConfig& noise = condition_.noise;
    std::vector<Evaluation> result;
    for (std::size_t i = 0; i < others_.size(); ++i) {
      const std::string& name = test_.against[i];
      if (is_always_there(name)) continue;
      result.push_back(judged(name, others_[i], set, noise, seed));
      if (changed && knows_plant(name))
        result.back().label = fmt::format("{}, {} parameters", row_of(name), name == kTrueEkf ? "true" : "nominal");
    }
    result.push_back(judged("constant", constant_, set, noise, seed));
    return result;
  }

  const Models& models_;
  const Experiment& nominal_;
  Experiment tested_;
  const StrictTest& test_;
  const Condition& condition_;
  std::unique_ptr<Plant> plant_;
  MetricsConfig config_;
  Dataset training_;
  std::vector<EstimatorFactory> readouts_;  ///< one per model
  std::vector<EstimatorFactory> others_;    ///< by `against`
  EstimatorFactory constant_;
};

}  // namespace

std::vector<Condition> conditions_of(const std::vector<NoiseConfig>& noises, const Condition& common) {
  std::vector<Condition> result(noises.size(), common);
  for (std::size_t i = 0; i < noises.size(); ++i) result[i].noise = noises[i];
  return result;
}

std::vector<std::string> alternative_names() {
  std::vector<std::string> names = filter_names();
  std::ranges::copy(simple_names(), std::back_inserter(names));
  return names;
}

std::vector<EvaluationStudy> run_strict_study(const std::vector<NamedModel>& models, const Experiment& experiment,
                                              const StrictTest& test, const StudyProgress& progress) {
  std::vector<EvaluationStudy> studies;
  const auto all = static_cast<double>(test.conditions.size());
  for (const Condition& condition : test.conditions) {
    const auto done = static_cast<double>(studies.size());
    studies.push_back(Row(models, experiment, test, condition).run([&](double share, const std::string& what) {
      if (progress) progress((done + share) / all, what);
    }));
  }
  return studies;
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
