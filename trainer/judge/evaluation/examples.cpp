// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/examples.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "codegen/model/domain.h"
#include "codegen/replay/reference_observer.h"
#include "trainer/judge/evaluation/metrics.h"

namespace nlo::trainer {
namespace {

/// Indices of the smallest and the largest error; the first one of equal errors. NaN is used only if all errors are
/// NaN.
struct Extremes {
  std::size_t best = 0, worst = 0;
};

Extremes extremes(const std::vector<double>& errors) {
  Extremes found;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (errors[i] < low) {
      low = errors[i];
      found.best = i;
    }
    if (errors[i] > high) {
      high = errors[i];
      found.worst = i;
    }
  }
  return found;
}

std::string reason(std::size_t run, const Extremes& e) {
  const bool told = e.best != e.worst;
  if (told && run == e.worst) return run == 0 ? "first and worst" : "worst";
  if (told && run == e.best) return run == 0 ? "first and best" : "best";
  return run == 0 ? "first" : "";
}

}  // namespace

double relative_error(const Trajectory& truth, const Eigen::MatrixXd& estimate, const std::vector<Channel>& states,
                      const Eigen::VectorXd& scale) {
  double squares = 0.0;
  for (Eigen::Index i = 0; i < truth.states.rows(); ++i) {
    const double wrap = states[static_cast<std::size_t>(i)].wrap;
    for (Eigen::Index k = 0; k < truth.samples(); ++k) {
      if (truth.weight[k] <= 0.0) continue;
      const double error = wrapped_difference(truth.states(i, k), estimate(i, k), wrap) / scale[i];
      squares += truth.weight[k] * error * error;
    }
  }
  const double weight = truth.weight.sum() * static_cast<double>(truth.states.rows());
  return weight > 0.0 ? std::sqrt(squares / weight) : std::numeric_limits<double>::quiet_NaN();
}

void FirstAndWorst::offer(std::size_t run, Eigen::MatrixXd measured, Eigen::MatrixXd estimate) {
  const double error = relative_error(clean_.trajectories[run], estimate, clean_.states, scale_);
  const std::lock_guard lock(mutex_);
  if (run == 0) {
    first_ = {run, error, std::move(measured), std::move(estimate)};
  } else if (error > worst_.error || (error == worst_.error && run < worst_.run)) {
    worst_ = {run, error, std::move(measured), std::move(estimate)};
  }
}

std::vector<EvaluatedRun> FirstAndWorst::take() {
  const auto example = [this](Kept& kept, const char* why) {
    return EvaluatedRun{clean_.trajectories[kept.run], std::move(kept.measured), std::move(kept.estimate), why};
  };
  const bool alone = clean_.trajectories.size() < 2;
  const bool first_is_worst = !(worst_.error > first_.error);
  std::vector<EvaluatedRun> examples;
  examples.push_back(example(first_, first_is_worst && !alone ? "first and worst" : "first"));
  if (!first_is_worst) examples.push_back(example(worst_, "worst"));
  return examples;
}

std::vector<Chosen> spread_choice(const std::vector<double>& errors, std::size_t most) {
  const Extremes e = extremes(errors);
  std::set<std::size_t> runs;
  if (errors.size() <= most) {
    for (std::size_t i = 0; i < errors.size(); ++i) runs.insert(i);
  } else {
    runs = {0, e.best, e.worst};
    const std::size_t others = most - runs.size();
    for (std::size_t i = 1; i <= others; ++i) {
      std::size_t run = i * (errors.size() - 1) / others;
      while (runs.count(run) > 0) run = (run + 1) % errors.size();
      runs.insert(run);
    }
  }
  std::vector<Chosen> chosen;
  for (const std::size_t run : runs) chosen.push_back({run, errors.size() > 1 ? reason(run, e) : "first"});
  return chosen;
}

Eigen::VectorXd outside_of_domain(const codegen::Model& model, const EvaluatedRun& run, bool uniform_steps) {
  codegen::ReferenceObserver<float> observer(model);
  const Eigen::Index samples = run.measured.cols(), nu = model.nu();
  const Eigen::MatrixXd& u = run.truth.inputs;
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(nu, nu > 0 ? samples : 0);
  const bool driven = nu > 0 && u.size() > 0;
  const codegen::Run flown = observer.run(run.measured, driven ? u : none, run.truth.time_s, uniform_steps);
  Eigen::VectorXd outside(samples);
  for (Eigen::Index k = 0; k < samples; ++k) outside[k] = flown.in_domain[static_cast<std::size_t>(k)] ? 0.0 : 1.0;
  return outside;
}

}  // namespace nlo::trainer
