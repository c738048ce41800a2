// SPDX-License-Identifier: MIT
#include "trainer/plants/initial_states.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <utility>

#include "codegen/base/splitmix.h"
#include "trainer/base/engine_draws.h"

namespace nlo::trainer {
std::uint64_t initial_state_seed(std::uint64_t seed, SeedStream stream) {
  return codegen::mixed(seed + 0x9E3779B97F4A7C15u * (static_cast<std::uint64_t>(stream) + 1));
}

namespace {

Eigen::VectorXd vector_of(const std::vector<double>& values) {
  return Eigen::VectorXd::Map(values.data(), static_cast<Eigen::Index>(values.size()));
}

Eigen::MatrixXd from_box(const SimulationConfig& config, std::mt19937_64& engine, Eigen::Index count, double scale) {
  const bool gaussian = config.initial_distribution == InitialDistribution::kGaussian;
  const auto nx = static_cast<Eigen::Index>(config.initial_low.size());
  Eigen::MatrixXd x(nx, count);
  for (Eigen::Index column = 0; column < count; ++column) {
    for (Eigen::Index i = 0; i < nx; ++i) {
      const double low = config.initial_low[static_cast<std::size_t>(i)];
      const double high = config.initial_high[static_cast<std::size_t>(i)];
      const double centre = 0.5 * (low + high), half_width = 0.5 * (high - low) * scale;
      x(i, column) = centre + half_width * (gaussian ? normal_pair(engine).first : 2.0 * uniform01(engine) - 1.0);
    }
  }
  return x;
}

/// x = centre + a cos phi + b sin phi
struct Circle {
  Eigen::VectorXd centre, a, b;
};

Circle circle_of(const SimulationConfig& config) {
  Circle circle{{}, vector_of(config.initial_axes.at(0)), vector_of(config.initial_axes.at(1))};
  circle.centre = config.initial_centre.empty() ? Eigen::VectorXd::Zero(circle.a.size())
                                                : Eigen::VectorXd(vector_of(config.initial_centre));
  return circle;
}

Eigen::MatrixXd from_circle(const Circle& circle, std::mt19937_64& engine, Eigen::Index count, double scale) {
  Eigen::MatrixXd x(circle.centre.size(), count);
  for (Eigen::Index column = 0; column < count; ++column) {
    const double phi = 2.0 * std::numbers::pi * uniform01(engine);
    x.col(column) = circle.centre + scale * (std::cos(phi) * circle.a + std::sin(phi) * circle.b);
  }
  return x;
}

Eigen::MatrixXd list_of(const SimulationConfig& config) {
  const auto count = static_cast<Eigen::Index>(config.initial_states.size());
  Eigen::MatrixXd list(static_cast<Eigen::Index>(config.initial_states.at(0).size()), count);
  for (Eigen::Index i = 0; i < count; ++i) list.col(i) = vector_of(config.initial_states[static_cast<std::size_t>(i)]);
  return list;
}

Eigen::MatrixXd from_list(Eigen::MatrixXd list, std::mt19937_64& engine, Eigen::Index count, double scale) {
  if (scale != 1.0) {
    const Eigen::VectorXd mean = list.rowwise().mean();
    list = (scale * (list.colwise() - mean)).colwise() + mean;
  }
  std::vector<Eigen::Index> order(static_cast<std::size_t>(list.cols()));
  Eigen::MatrixXd x(list.rows(), count);
  for (Eigen::Index column = 0; column < count; ++column) {
    const auto place = static_cast<std::size_t>(column % list.cols());
    if (place == 0) {
      std::iota(order.begin(), order.end(), Eigen::Index{0});
      for (std::size_t i = order.size() - 1; i > 0; --i)
        std::swap(order[i], order[static_cast<std::size_t>(uniform01(engine) * static_cast<double>(i + 1))]);
    }
    x.col(column) = list.col(order[place]);
  }
  return x;
}

}  // namespace

Eigen::MatrixXd draw_initial_states(const SimulationConfig& config, std::uint64_t engine_seed, Eigen::Index count,
                                    double box_scale) {
  std::mt19937_64 engine(engine_seed);
  if (config.initial_distribution == InitialDistribution::kCircle)
    return from_circle(circle_of(config), engine, count, box_scale);
  if (config.initial_distribution == InitialDistribution::kList)
    return from_list(list_of(config), engine, count, box_scale);
  return from_box(config, engine, count, box_scale);
}

InitialBox initial_box(const SimulationConfig& config) {
  if (config.initial_distribution == InitialDistribution::kCircle) {
    const Circle circle = circle_of(config);
    const Eigen::VectorXd reach = (circle.a.cwiseAbs2() + circle.b.cwiseAbs2()).cwiseSqrt();
    return {circle.centre - reach, circle.centre + reach};
  }
  if (config.initial_distribution == InitialDistribution::kList) {
    const Eigen::MatrixXd list = list_of(config);
    return {list.rowwise().minCoeff(), list.rowwise().maxCoeff()};
  }
  return {vector_of(config.initial_low), vector_of(config.initial_high)};
}

InitialMoments initial_moments(const SimulationConfig& config) {
  if (config.initial_distribution == InitialDistribution::kCircle) {
    const Circle circle = circle_of(config);
    return {circle.centre, 0.5 * (circle.a * circle.a.transpose() + circle.b * circle.b.transpose())};
  }
  if (config.initial_distribution == InitialDistribution::kList) {
    const Eigen::MatrixXd list = list_of(config);
    const Eigen::VectorXd mean = list.rowwise().mean();
    const Eigen::MatrixXd from_mean = list.colwise() - mean;
    return {mean, from_mean * from_mean.transpose() / static_cast<double>(list.cols())};
  }
  const auto [low, high] = initial_box(config);
  const double per_width = config.initial_distribution == InitialDistribution::kGaussian ? 4.0 : 12.0;
  const Eigen::VectorXd variance = (high - low).cwiseAbs2() / per_width;
  return {0.5 * (low + high), Eigen::MatrixXd(variance.asDiagonal())};
}

}  // namespace nlo::trainer
