// SPDX-License-Identifier: MIT
#include "trainer/prove/map_constants.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/base/linear_algebra.h"
#include "trainer/prove/forward_map.h"
#include "trainer/prove/lipschitz.h"
#include "trainer/prove/robustness_bound.h"

namespace nlo::trainer {
namespace {

using codegen::Error;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr Eigen::Index kJacobianPoints = 120;  // each costs 8 backward runs on a plant of two states
constexpr Eigen::Index kPairPoints = 600;      // 180,000 pairs

double smallest_singular_value(const Eigen::MatrixXd& matrix) {
  const Eigen::VectorXd sigma = codegen::singular_values(matrix);
  return matrix.rows() < matrix.cols() ? 0.0 : sigma(sigma.size() - 1);
}

/// Returns `count` columns spread over runs and time: column j is from run j modulo the number of runs, at time j /
/// count of the horizon.
Eigen::MatrixXd spread(const std::vector<Eigen::MatrixXd>& path, Eigen::Index count) {
  const auto samples = static_cast<Eigen::Index>(path.size());
  Eigen::MatrixXd result(path.front().rows(), count);
  for (Eigen::Index j = 0; j < count; ++j)
    result.col(j) = path[static_cast<std::size_t>(j * samples / count)].col(j % path.front().cols());
  return result;
}

/// Returns the largest |x1 - x2| / |z1 - z2| over all pairs of columns that are far enough apart.
double inverse_slope(const Eigen::MatrixXd& x, const Eigen::MatrixXd& z) {
  // Smallest distance of a pair, as a share of the states' spread. For closer pairs, rounding errors of T would
  // dominate.
  constexpr double kApart = 1e-3;
  const double apart = kApart * (x.rowwise().maxCoeff() - x.rowwise().minCoeff()).norm();
  double largest = 0.0;
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    for (Eigen::Index j = 0; j < i; ++j) {
      const double distance = (x.col(i) - x.col(j)).norm();
      if (distance > apart) largest = std::max(largest, distance / (z.col(i) - z.col(j)).norm());
    }
  return largest;
}

}  // namespace

MapConstants exact_map_constants(const LinearPlant& plant, const LatentSystem& system, const Eigen::MatrixXd& initial) {
  constexpr double kRank = 1e-12;
  MapConstants map;
  map.exact = true;
  map.matrix = sylvester_map(plant.a(), plant.c(), system);
  map.l_tx = spectral_norm(map.matrix);
  const double smallest = smallest_singular_value(map.matrix);
  if (smallest <= kRank * map.l_tx)
    throw Error(
        fmt::format("plant {}: T of these eigenvalues is not injective ({} modes that read an output, {} states), so "
                    "no bound exists; "
                    "use at least as many distinct eigenvalues as states, on an observable plant",
                    plant.name(), system.nz(), plant.nx()));
  map.l_t = 1.0 / smallest;
  widen_row_slopes(modes_of(system), map.matrix, map.row_slopes);
  map.start = map.matrix * initial;
  return map;
}

MapConstants sampled_map_constants(const Plant& plant, const LatentSystem& system, const Dataset& runs,
                                   const Eigen::MatrixXd& initial) {
  constexpr double kGrowth = 1.5, kFiner = 0.1;
  const auto samples = runs.trajectories.front().samples();
  Eigen::MatrixXd extremes(plant.nx(), 2 * static_cast<Eigen::Index>(runs.trajectories.size()));
  for (std::size_t i = 0; i < runs.trajectories.size(); ++i) {
    const Eigen::MatrixXd& states = runs.trajectories[i].states;
    extremes.col(static_cast<Eigen::Index>(2 * i)) = states.rowwise().minCoeff();
    extremes.col(static_cast<Eigen::Index>(2 * i + 1)) = states.rowwise().maxCoeff();
  }
  ForwardMapOptions options;
  options.longest_step_s = runs.sample_period_s;
  const ForwardMap forward(plant, system, domain_around(extremes), options);

  MapConstants map;
  const ForwardMap::Path path = forward.along(initial, runs.sample_period_s, samples);
  map.start = path.z.front();
  constexpr Eigen::Index kErrorPoints = 20000;
  map.x = spread(path.x, kErrorPoints);
  map.z = spread(path.z, kErrorPoints);
  map.l_t = inverse_slope(spread(path.x, kPairPoints), spread(path.z, kPairPoints));

  const Eigen::MatrixXd points = spread(path.x, kJacobianPoints);
  for (const Eigen::MatrixXd& jacobian : forward.jacobians(points)) {
    map.l_tx = std::max(map.l_tx, spectral_norm(jacobian));
    const double smallest = smallest_singular_value(jacobian);
    map.l_t = std::max(map.l_t, smallest > 0.0 ? 1.0 / smallest : kInfinity);
    widen_row_slopes(modes_of(system), jacobian, map.row_slopes);
  }
  const std::vector<LatentMode> modes = modes_of(system);
  Eigen::VectorXd finer;
  for (const Eigen::MatrixXd& jacobian : forward.jacobians(points, kFiner * options.difference_step))
    widen_row_slopes(modes, jacobian, finer);
  for (Eigen::Index i = 0; i < finer.size(); ++i) {
    if (finer(i) <= kGrowth * map.row_slopes(i)) continue;
    map.row_slopes(i) = kInfinity;  // the slope has no limit: T is continuous there, but not differentiable
    map.l_tx = kInfinity;
  }
  // T is evaluated at the initial states only: near an attractor, backward runs from neighbouring states diverge, and
  // with them differences of T.
  const Eigen::MatrixXd t = map.start, y = plant.output(initial);
  const Eigen::VectorXd size =
      (apply_d(system, t).colwise().norm() + (system.injection * y).colwise().norm()).transpose();
  map.pde_residual = forward.pde_residual(initial).maxCoeff() / size.maxCoeff();
  return map;
}

}  // namespace nlo::trainer
