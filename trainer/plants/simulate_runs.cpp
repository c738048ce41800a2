// SPDX-License-Identifier: MIT
#include "trainer/plants/simulate_runs.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "codegen/reference/rk4.h"
#include "trainer/plants/drawn_inputs.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/run_random.h"
#include "trainer/plants/simulate.h"
#include "trainer/plants/state_feedback.h"

namespace nlo::trainer {
namespace {

/// Returns u (n_u x B, or 0 x B) of the runs of a batch at the fraction c of the step from sample k.
using StepInputs = std::function<Eigen::MatrixXd(Eigen::Index k, double c)>;

/// Runs of a set that are simulated together because they have the same plant.
struct Batch {
  Eigen::Index first, count;
};

StepInputs step_inputs(const Experiment& experiment, const Excitation& given, const Dataset& set, const Batch& batch) {
  if (given)
    return [&given, count = batch.count, h = set.sample_period_s](Eigen::Index k, double c) -> Eigen::MatrixXd {
      return given(static_cast<double>(k) * h + c * h).replicate(1, count);
    };
  const auto nu = static_cast<Eigen::Index>(set.inputs.size());
  const auto at_sample = [&set, batch, nu](Eigen::Index k) {
    Eigen::MatrixXd u(nu, batch.count);
    for (Eigen::Index i = 0; i < batch.count && nu > 0; ++i)
      u.col(i) = set.trajectories[static_cast<std::size_t>(batch.first + i)].inputs.col(k);
    return u;
  };
  if (experiment.observer.input_hold == Hold::kZeroOrder)
    return [at_sample](Eigen::Index k, double) { return at_sample(k + 1); };
  return [at_sample](Eigen::Index k, double c) -> Eigen::MatrixXd {
    return (1.0 - c) * at_sample(k) + c * at_sample(k + 1);
  };
}

/// Closes the loop of the runs of a set that are in closed loop: u_k = k(x_hat_k, r_k) acts over (t_k, t_{k+1}].
class Loop {
 public:
  Loop(const Experiment& experiment, const Plant& plant, std::uint64_t engine_seed, const LoopEstimators& estimators)
      : feedback_(*experiment.feedback),
        channels_(*experiment.plant, plant),
        law_(feedback_, plant, *experiment.plant),
        engine_seed_(engine_seed),
        make_(estimators) {}

  /// Sets the input before the run, with the actuator at rest.
  void begin(Eigen::Index run, Trajectory& trajectory) {
    if (!in_closed_loop(feedback_, run)) return;
    trajectory.inputs.col(0) = law_.clipped(Eigen::VectorXd::Zero(trajectory.inputs.rows()));
    const auto number = static_cast<std::uint64_t>(run);
    InLoop& own = runs_.emplace_back();
    own.run = run;
    if (make_) {
      own.estimator = make_(number);
      return;
    }
    own.error = Eigen::VectorXd::Zero(trajectory.states.rows());
    RunRandom random(engine_seed_, RunPurpose::kEstimateError, 0, number);
    for (std::size_t i = 0; i < feedback_.error.size(); ++i)
      own.error(static_cast<Eigen::Index>(i)) = feedback_.error[i] * random.normal();
  }

  /// Closes the loop at sample k of all runs in closed loop. inputs(:,k+1) holds the reference and is replaced by u.
  void close(Eigen::Index k, Dataset& set) {
    for (InLoop& own : runs_) {
      Trajectory& run = set.trajectories[static_cast<std::size_t>(own.run)];
      const Eigen::VectorXd x_hat = own.estimator ? own.estimator->step(run.outputs.col(k), run.inputs.col(k))
                                                  : Eigen::VectorXd(channels_.states(run.states.col(k) + own.error));
      run.inputs.col(k + 1) = law_(x_hat, run.inputs.col(k + 1));
    }
  }

 private:
  struct InLoop {
    Eigen::Index run = 0;
    std::unique_ptr<LoopEstimator> estimator = {};  ///< null: the true state plus `error`
    Eigen::VectorXd error = {};
  };

  const FeedbackConfig& feedback_;
  PlantChannels channels_;
  StateFeedback law_;
  std::uint64_t engine_seed_;
  const LoopEstimators& make_;
  std::vector<InLoop> runs_;
};

void simulate_batch(const Plant& plant, const Experiment& experiment, const Eigen::MatrixXd& initial,
                    std::uint64_t engine_seed, const Batch& batch, const StepInputs& inputs, Loop* loop, Dataset& set) {
  const double h = set.sample_period_s;
  const Eigen::Index samples = sample_count(experiment.simulation);
  const auto& intensity = experiment.simulation.process_noise;
  const Eigen::ArrayXd deviation =
      std::sqrt(h) * Eigen::ArrayXd::Map(intensity.data(), static_cast<Eigen::Index>(intensity.size()));
  std::vector<std::pair<Eigen::Index, RunRandom>> disturbances;  // of the runs with process noise, by column of x
  for (Eigen::Index i = 0; i < batch.count; ++i)
    if (const auto run = static_cast<std::uint64_t>(batch.first + i); experiment.simulation.has_process_noise(run))
      disturbances.emplace_back(i, RunRandom(engine_seed, RunPurpose::kProcessNoise, 0, run));

  Eigen::MatrixXd x = initial.middleCols(batch.first, batch.count);
  const Eigen::MatrixXd start = x;
  for (Eigen::Index i = batch.first; loop != nullptr && i < batch.first + batch.count; ++i)
    loop->begin(i, set.trajectories[static_cast<std::size_t>(i)]);
  for (Eigen::Index k = 0; k < samples; ++k) {
    const Eigen::MatrixXd y = plant.output(x);
    refuse_escape(plant, plant.states(), x, start, static_cast<double>(k) * h);
    refuse_escape(plant, plant.outputs(), y, start, static_cast<double>(k) * h);
    for (Eigen::Index i = 0; i < batch.count; ++i) {
      Trajectory& run = set.trajectories[static_cast<std::size_t>(batch.first + i)];
      run.states.col(k) = x.col(i);
      run.outputs.col(k) = y.col(i);
    }
    if (k + 1 == samples) return;
    if (loop != nullptr) loop->close(k, set);
    x = codegen::rk4_step(
        x, h, [&](double c, const Eigen::MatrixXd& at) { return plant.driven_derivative(at, inputs(k, c)); });
    for (auto& [i, random] : disturbances)
      for (Eigen::Index row = 0; row < deviation.size(); ++row) x(row, i) += deviation(row) * random.normal();
  }
}

/// Sets the inputs at the samples, drawn or from u(t).
void fill_inputs(const Experiment& experiment, const Plant& plant, std::uint64_t engine_seed, const Excitation& given,
                 Dataset& set) {
  if (!given && !experiment.moves_inputs()) return;
  set.inputs = plant.inputs();
  if (!given && !experiment.excitation) {
    for (Trajectory& run : set.trajectories) run.inputs.setZero(plant.nu(), run.samples());
    return;
  }
  const LoggedInputs log = given ? LoggedInputs{} : read_logged_inputs(*experiment.excitation, experiment.simulation);
  for (std::size_t i = 0; i < set.trajectories.size(); ++i) {
    Trajectory& run = set.trajectories[i];
    if (!given) {
      run.inputs = draw_inputs(*experiment.excitation, experiment.simulation, engine_seed, i, log);
      continue;
    }
    run.inputs.resize(plant.nu(), run.samples());
    for (Eigen::Index k = 0; k < run.samples(); ++k)
      run.inputs.col(k) = given(static_cast<double>(k) * set.sample_period_s);
  }
}

/// Returns the stream of a parameter. It depends only on its name (FNV-1a), not on other draws.
std::uint64_t stream_of(std::string_view name) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return hash;
}

}  // namespace

PlantConfig draw_parameters(const PlantConfig& plant, std::uint64_t engine_seed, std::uint64_t run) {
  PlantConfig drawn = plant;
  drawn.parameter_ranges.clear();
  for (const auto& [name, range] : plant.parameter_ranges) {
    RunRandom random(engine_seed, RunPurpose::kParameters, stream_of(name), run);
    for (auto& [parameter, value] : drawn.parameters)
      if (parameter == name) value = random.between(range[0], range[1]);
  }
  return drawn;
}

Dataset simulate_runs(const Experiment& experiment, const Plant& plant, std::uint64_t engine_seed, Eigen::Index count,
                      double box_scale, const Excitation& given, const LoopEstimators& estimators) {
  const SimulationConfig& simulation = experiment.simulation;
  const bool own_plants = !experiment.plant->parameter_ranges.empty();
  const bool drawn_inputs = experiment.moves_inputs() && !given;
  if (!own_plants && !drawn_inputs && simulation.process_noise.empty())
    return simulate(plant, simulation, engine_seed, count, box_scale, given);

  const Eigen::MatrixXd initial = draw_initial_states(simulation, engine_seed, count, box_scale);
  Dataset set = empty_runs(plant, simulation, count);
  fill_inputs(experiment, plant, engine_seed, given, set);
  const bool closed = experiment.feedback && !given;
  if (!own_plants) {
    const Batch all{0, count};
    std::optional<Loop> loop;
    if (closed) loop.emplace(experiment, plant, engine_seed, estimators);
    simulate_batch(plant, experiment, initial, engine_seed, all, step_inputs(experiment, given, set, all),
                   loop ? &*loop : nullptr, set);
  } else {
    for (Eigen::Index i = 0; i < count; ++i) {
      const Batch one{i, 1};
      const auto own = make_plant(draw_parameters(*experiment.plant, engine_seed, static_cast<std::uint64_t>(i)));
      std::optional<Loop> loop;
      if (closed) loop.emplace(experiment, plant, engine_seed, estimators);
      simulate_batch(*own, experiment, initial, engine_seed, one, step_inputs(experiment, given, set, one),
                     loop ? &*loop : nullptr, set);
    }
  }
  unwrap_outputs(set);
  return set;
}

Eigen::VectorXd farthest_states(const Experiment& experiment) {
  constexpr Eigen::Index kRuns = 20;
  constexpr double kFarther = 10.0;
  const auto plant = make_plant(*experiment.plant);
  const Dataset runs =
      simulate_runs(experiment, *plant, initial_state_seed(experiment.seed, SeedStream::kValidation), kRuns);
  Eigen::VectorXd farthest = Eigen::VectorXd::Zero(plant->nx());
  for (const Trajectory& run : runs.trajectories)
    farthest = farthest.cwiseMax(run.states.cwiseAbs().rowwise().maxCoeff());
  return kFarther * farthest.cwiseMax(1e-9 * farthest.maxCoeff());
}

}  // namespace nlo::trainer
