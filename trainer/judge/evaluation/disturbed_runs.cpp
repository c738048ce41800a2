// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/disturbed_runs.h"

#include <fmt/format.h>

#include "codegen/base/error.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

/// The plant f(x) + w, with a column of w for each column of x.
class Pushed final : public Plant {
 public:
  explicit Pushed(const Plant& plant) : Plant(plant.name(), plant.states(), plant.outputs()), plant_(plant) {}

  Eigen::MatrixXd w;

  Eigen::MatrixXd derivative(const Eigen::MatrixXd& x) const override { return plant_.derivative(x) + w; }
  Eigen::MatrixXd output(const Eigen::MatrixXd& x) const override { return plant_.output(x); }

 private:
  const Plant& plant_;
};

Eigen::VectorXd direction(MeasurementNoise& normal, Eigen::Index nx) {
  Eigen::VectorXd v(nx);
  do {
    for (double& x : v) x = normal.draw();
  } while (v.norm() < 1e-6);
  return v.normalized();
}

}  // namespace

DisturbedRuns simulate_disturbed(const Plant& plant, const SimulationConfig& config, const Eigen::MatrixXd& initial,
                                 double w_bar, std::uint64_t seed) {
  constexpr double kEscape = 1e9;
  const Eigen::Index samples = sample_count(config), count = initial.cols();
  const double h = config.sample_period_s;
  DisturbedRuns result{{plant.outputs(), plant.states(), h, true, {}},
                       Eigen::VectorXd::Zero(plant.ny()),
                       Eigen::VectorXd::Zero(plant.ny())};
  auto& runs = result.set.trajectories;
  std::vector<MeasurementNoise> random;
  for (Eigen::Index i = 0; i < count; ++i) {
    runs.push_back({fmt::format("simulation {}", i),
                    Eigen::VectorXd::LinSpaced(samples, 0.0, static_cast<double>(samples - 1)) * h,
                    Eigen::MatrixXd(plant.ny(), samples), Eigen::MatrixXd(plant.nx(), samples),
                    Eigen::VectorXd::Ones(samples)});
    random.emplace_back(NoiseConfig{NoiseKind::kGaussian, 1.0}, ~seed, static_cast<std::uint64_t>(i));
  }
  Pushed pushed(plant);
  pushed.w = Eigen::MatrixXd::Zero(plant.nx(), count);
  Eigen::MatrixXd x = initial, y = plant.output(x);
  for (Eigen::Index k = 0;; ++k) {
    if (!((x.array().abs() <= kEscape).all() && (y.array().abs() <= kEscape).all()))
      throw codegen::Error(
          fmt::format("plant {}: a run with |w| <= {:.6g} is not finite or exceeds 1e9 at t = {:.6g} s; use a smaller "
                      "--disturbance",
                      plant.name(), w_bar, static_cast<double>(k) * h));
    for (Eigen::Index i = 0; i < count; ++i) {
      runs[static_cast<std::size_t>(i)].states.col(k) = x.col(i);
      runs[static_cast<std::size_t>(i)].outputs.col(k) = y.col(i);
    }
    if (k + 1 == samples) return result;
    for (Eigen::Index i = 0; i < count && w_bar > 0.0; ++i)
      if (k == 0 || i % 2 == 1) pushed.w.col(i) = w_bar * direction(random[static_cast<std::size_t>(i)], plant.nx());
    const Eigen::MatrixXd y_middle = plant.output(rk4_step(pushed, x, 0.5 * h));
    x = rk4_step(pushed, x, h);
    const Eigen::MatrixXd y_next = plant.output(x);
    const auto widen = [](Eigen::VectorXd& largest, const Eigen::MatrixXd& difference) {
      largest = largest.cwiseMax(difference.cwiseAbs().rowwise().maxCoeff());
    };
    widen(result.ramp_error, y_middle - 0.5 * (y + y_next));
    widen(result.step_error, y_middle - y);
    widen(result.step_error, y_next - y);
    y = y_next;
  }
}

}  // namespace nlo::trainer
