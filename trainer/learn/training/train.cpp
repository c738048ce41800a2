// SPDX-License-Identifier: MIT
#include "trainer/learn/training/train.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/base/number_text.h"
#include "trainer/base/parallel.h"
#include "trainer/learn/losses/loss_registry.h"
#include "trainer/learn/optim/optimiser.h"
#include "trainer/learn/training/messages.h"
#include "trainer/learn/training/no_progress.h"
#include "trainer/learn/training/objective.h"
#include "trainer/learn/training/parameter_groups.h"
#include "trainer/learn/training/provenance.h"
#include "trainer/learn/training/shipped_model.h"
#include "trainer/learn/training/tune_constants.h"
#include "trainer/structures/structure.h"
#include "trainer/structures/structure_table.h"

namespace nlo::trainer {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void require_trainable(const Dataset& dataset, const std::string& which) {
  if (dataset.trajectories.empty()) throw codegen::Error("the " + which + " set holds no trajectories");
  bool counts = false;
  for (const Trajectory& trajectory : dataset.trajectories) {
    if (trajectory.samples() < 2) throw codegen::Error(trajectory.source + ": fewer than two samples");
    counts = counts || trajectory.weight.size() == 0 || trajectory.weight.maxCoeff() > 0.0;
  }
  if (!counts) throw codegen::Error("every sample of the " + which + " set is masked: mask less, or add longer runs");
}

class Training {
 public:
  Training(const Experiment& experiment, const Dataset& training, const Dataset& validation,
           const TrainOptions& options)
      : experiment_(experiment),
        dataset_(training),
        options_(options),
        failures_(structure_of(experiment.observer).failures(experiment, training)),
        training_data_(training, failures_),
        validation_data_(&training == &validation ? std::nullopt
                                                  : std::optional<TrainingData>(std::in_place, validation, failures_)),
        structure_(make_structure(experiment, needs_forward_map(experiment.loss), training.outputs, training.states,
                                  training.inputs_read(), static_cast<int>(failures_.outputs.size()))),
        pool_(experiment.threads),
        objective_(experiment_, structure_, training_data_, pool_),
        validator_(experiment_, structure_, validation_data_ ? *validation_data_ : training_data_, pool_),
        optimiser_(experiment.training.optimiser, parameter_groups(experiment, structure_)),
        data_hash_(training_data_hash(training, validation)),
        fingerprint_(run_fingerprint(experiment, data_hash_)) {}

  TrainingResult run() {
    const auto started = Clock::now();
    start();
    const double before_s = state_.elapsed_s;
    const long first_step = state_.step;
    double last_saved_s = 0.0;
    const TrainingConfig& config = experiment_.training;
    std::vector<float> gradient(state_.parameters.size());
    TrainingResult result;
    while (state_.step < config.steps) {
      if (options_.stop != nullptr && options_.stop->load()) {
        result.outcome = TrainOutcome::kInterrupted;
        break;
      }
      if (!eigenvalues_are_finite()) {
        result.outcome = TrainOutcome::kDiverged;
        result.message = diverged_by("an eigenvalue overflowed");
        break;
      }
      const ObjectiveValue value = objective_.evaluate(state_.parameters.data(), state_.step, gradient.data());
      const bool usable = std::all_of(gradient.begin(), gradient.end(), [](float g) { return std::isfinite(g); });
      unusable_ = usable ? 0 : unusable_ + 1;
      const bool runs_away = ran_away(value);
      if (runs_away && result.returns < kMostReturns) {
        ++result.returns;
        return_to_best();
      } else if (runs_away || diverged(value.loss, usable)) {
        result.outcome = TrainOutcome::kDiverged;
        result.message =
            diverged_by(usable ? "the loss is " + shortest_text(value.loss) : "the gradient is not finite");
        break;
      }
      clip(gradient, config.gradient_clip);
      const double factor = warm_up() * schedule_factor(config, state_.step);
      if (usable && !runs_away) optimiser_.step(state_.parameters.data(), gradient.data(), state_.step, factor);
      constrain(state_.parameters);
      if (!eigenvalues_are_finite()) continue;  // diverged: leave it out of the average
      average();
      ++state_.step;
      const double elapsed_s = seconds_since(started);
      state_.elapsed_s = before_s + elapsed_s;
      if (state_.step % config.validate_every == 0 || state_.step == config.steps) {
        validate(value, factor * config.learning_rate);
      }
      if (elapsed_s - last_saved_s > config.checkpoint_every_s) {
        save();
        last_saved_s = elapsed_s;
      }
      if (options_.progress)
        options_.progress(progress_of(experiment_, structure_, state_, value.loss, first_step, elapsed_s));
    }
    save();
    if (result.outcome == TrainOutcome::kFinished) judge(result);
    ShippedModel shipped = shipped_model({experiment_, dataset_, options_, structure_, failures_, state_, data_hash_},
                                         objective_, validator_, pool_);
    result.model = std::move(shipped.model);
    result.readout = std::move(shipped.readout);
    result.left_out = std::move(shipped.left_out);
    result.validation_rmse = shipped.validation_rmse;
    result.split = shipped.split;
    if (result.succeeded() && is_chosen(experiment_.inverse_map.readout))
      if (std::string below = below_floor(result.readout); !below.empty()) {
        result.message = std::move(below);
        result.outcome = TrainOutcome::kBelowFloor;
      }
    result.metrics = state_.metrics;
    result.steps_done = state_.step;
    result.elapsed_s = state_.elapsed_s;
    result.groups = options_.evidence.size();
    return result;
  }

 private:
  std::string path(const char* file) const { return options_.directory + "/" + file; }

  void start() {
    // The scales of the features are computed with the initial latent system. They belong to the structure, not to the
    // parameters.
    normalise_dynamics(structure_, training_data_, pool_);
    tune_constants(structure_, experiment_, training_data_, pool_);
    const Rollout& rollout = objective_.roll_out_flight(initial_dynamics(structure_, experiment_).data());
    normalise(structure_, rollout);
    std::vector<float> initial = initial_parameters(structure_, experiment_, rollout);
    constrain(initial);
    ObjectiveValue untrained;
    const bool is_estimator = starts_as_estimator(structure_);
    if (is_estimator) validator_.split_validation_at(settled_from(experiment_, dataset_, options_));
    if (is_estimator || !options_.resume) untrained = validator_.validation(initial.data());
    if (is_estimator) filter_ = untrained;
    if (options_.resume) {
      const auto parameters = static_cast<std::size_t>(structure_.parameters());
      const std::size_t eigenvalues = structure_.eigenvalues_at(std::vector<float>(parameters).data()).size();
      state_ = read_checkpoint(path("checkpoint.bin"), {.fingerprint = fingerprint_,
                                                        .parameters = parameters,
                                                        .memory = optimiser_.memory().size(),
                                                        .eigenvalues = eigenvalues,
                                                        .steps = experiment_.training.steps});
      optimiser_.memory() = state_.memory;
      return;
    }
    state_.parameters = state_.average = state_.best = initial;
    // tanh turns infinities into finite values, so the features are checked, too.
    const bool finite = std::all_of(structure_.features.begin(), structure_.features.end(), [](const Feature& feature) {
      return std::isfinite(feature.mean) && std::isfinite(feature.scale);
    });
    if (!finite || !std::isfinite(untrained.rmse)) {
      throw codegen::Error(
          "the error of the untrained observer is not finite: the data contain such a number, or the latent "
          "system is unstable at this sample period (hold \"rk4\" with |eigenvalue| * period above 2.78); use hold "
          "\"first_order\" or slower eigenvalues");
    }
    state_.best_rmse = untrained.rmse;
    add_metrics(objective_.evaluate(state_.parameters.data(), 0, nullptr), untrained.rmse,
                experiment_.training.learning_rate);
  }

  void judge(TrainingResult& result) {
    result.message = no_progress(state_.metrics);
    if (result.message.empty()) return;
    const Rollout& flight = objective_.roll_out_flight(state_.parameters.data());
    if (closed_form_is_best(state_.metrics, structure_, dataset_, flight)) {
      result.outcome = TrainOutcome::kClosedForm;
      result.message = closed_form_text(state_.metrics);
      return;
    }
    result.outcome = TrainOutcome::kNoProgress;
    result.message += ". " + likely_causes(experiment_, state_.metrics, structure_, dataset_, flight);
  }

  void constrain(std::vector<float>& parameters) const {
    structure_of(experiment_.observer).constrain(structure_, parameters.data());
  }

  /// Exponential average of the weights. Its memory is short at first, so that it soon forgets the initial weights.
  void average() {
    const double ema = experiment_.training.ema;
    const auto t = static_cast<double>(state_.step);
    const auto keep = static_cast<float>(std::min(ema, (1.0 + t) / (10.0 + t)));
    const float take = ema > 0.0 ? 1.0F - keep : 1.0F;
    for (std::size_t i = 0; i < state_.average.size(); ++i) {
      state_.average[i] += take * (state_.parameters[i] - state_.average[i]);
    }
    constrain(state_.average);
  }

  void validate(const ObjectiveValue& value, double rate) {
    const ObjectiveValue validation = validator_.validation(state_.average.data());
    add_metrics(value, validation.rmse, rate);
    if (std::isfinite(validation.rmse) && validation.rmse < state_.best_rmse && !is_behind_filter(validation)) {
      state_.best_rmse = validation.rmse;
      state_.best = state_.average;
    }
  }

  bool is_behind_filter(const ObjectiveValue& validation) const {
    if (!filter_) return false;
    std::vector<double> deviations(structure_.state_scale.begin(), structure_.state_scale.end());
    if (experiment_.loss.is_normalised()) deviations.assign(deviations.size(), 1.0);
    return is_behind(validation, *filter_, deviations);
  }

  void add_metrics(const ObjectiveValue& value, double validation_rmse, double rate) {
    state_.metrics.push_back({.step = state_.step,
                              .elapsed_s = state_.elapsed_s,
                              .loss = value.loss,
                              .train_rmse = value.rmse,
                              .validation_rmse = validation_rmse,
                              .learning_rate = rate,
                              .eigenvalues = structure_.eigenvalues_at(state_.average.data())});
  }

  bool clips() const { return experiment_.training.gradient_clip > 0.0; }

  /// Over a long time a gradient may overflow now and then. If gradients are clipped, such a step is left out.
  bool diverged(double loss, bool usable) const {
    if (!std::isfinite(loss)) return true;
    if (!usable && !clips()) return true;
    return loss > 1e6 * (1.0 + std::abs(state_.metrics.front().loss));  // a logarithmic loss may be negative
  }

  /// Returns true if small changes of the parameters grow so fast through time that gradients are useless. Only for
  /// trainings that clip gradients.
  bool ran_away(const ObjectiveValue& value) const {
    constexpr int kMostUnusable = 20;  // in a row
    constexpr double kFar = 4.0;       // times the best validation error; noise alone makes a factor below 2
    if (!clips()) return false;
    // Segments that begin anywhere contain more of a transient than whole validation runs. The estimates of an
    // untrained observer are nearly constant and hardly show it, so the error is also compared with that of the best
    // observer.
    const MetricsRow& first = state_.metrics.front();
    const MetricsRow& best = *std::ranges::min_element(state_.metrics, {}, &MetricsRow::validation_rmse);
    const double harder =
        std::max({1.0, first.train_rmse / first.validation_rmse, best.train_rmse / best.validation_rmse});
    return unusable_ > kMostUnusable || !std::isfinite(value.loss) || value.rmse > kFar * harder * state_.best_rmse;
  }

  void return_to_best() {
    state_.returned_at = state_.step;
    state_.parameters = state_.average = state_.best;
    optimiser_.forget_direction();
    unusable_ = 0;
  }

  /// Returns a factor of the learning rate. After a return it rises linearly to 1: at the full rate, training would run
  /// away from the same model again.
  double warm_up() const {
    constexpr double kSteps = 200.0;
    if (state_.returned_at < 0) return 1.0;
    return std::min(1.0, static_cast<double>(state_.step - state_.returned_at) / kSteps);
  }

  /// Infinite eigenvalues have no discretisation: scaling and squaring would never end.
  bool eigenvalues_are_finite() const {
    const std::vector<double> eigenvalues = structure_.eigenvalues_at(state_.parameters.data());
    return std::all_of(eigenvalues.begin(), eigenvalues.end(), [](double lambda) { return std::isfinite(lambda); });
  }

  std::string diverged_by(const std::string& what) const {
    return divergence_message(experiment_, structure_, state_.step, what);
  }

  void save() {
    if (options_.directory.empty()) return;
    state_.memory = optimiser_.memory();
    write_checkpoint(state_, fingerprint_, path("checkpoint.bin"));
    codegen::write_file_atomically(path("metrics.csv"), metrics_csv(state_.metrics, structure_.pairs()));
  }

  const Experiment& experiment_;
  const Dataset& dataset_;
  const TrainOptions& options_;
  codegen::SensorFailures failures_;
  TrainingData training_data_;
  std::optional<TrainingData> validation_data_;  ///< empty: the training set also validates
  ObserverStructure structure_;
  ThreadPool pool_;
  Objective objective_, validator_;
  Optimiser optimiser_;
  std::uint64_t data_hash_, fingerprint_;
  TrainingState state_;
  std::optional<ObjectiveValue> filter_;  ///< validation errors of the filter that training began with, if it was one
  int unusable_ = 0;                      ///< number of gradients in a row that are not finite
  static constexpr int kMostReturns = 20;
};

}  // namespace

TrainingResult train(const Experiment& experiment, const Dataset& training, const Dataset& validation,
                     const TrainOptions& options) {
  require_trainable(training, "training");
  require_trainable(validation, "validation");
  if (!options.directory.empty()) std::filesystem::create_directories(options.directory);
  return Training(experiment, training, validation, options).run();
}

}  // namespace nlo::trainer
