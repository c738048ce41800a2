// SPDX-License-Identifier: MIT
#include "trainer/identify/parameter_space.h"

#include <algorithm>
#include <cmath>

namespace nlo::trainer {

using Eigen::Index;
using Eigen::VectorXd;

ParameterSpace::ParameterSpace(const PlantConfig& plant, const IdentifyConfig& identify) {
  const auto listed = [](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  start_.resize(static_cast<Index>(plant.parameters.size()));
  for (std::size_t i = 0; i < plant.parameters.size(); ++i) {
    const auto& [name, value] = plant.parameters[i];
    start_[static_cast<Index>(i)] = value;
    if (listed(identify.fixed, name)) continue;
    Coordinate coordinate{name, static_cast<Index>(i), Kind::kFree, value, 0.0, 0.0};
    if (listed(identify.positive, name)) coordinate.kind = Kind::kPositive;
    for (const auto& [bounded, range] : plant.parameter_ranges)
      if (bounded == name) {
        coordinate.kind = Kind::kBounded;
        coordinate.low = range[0];
        coordinate.high = range[1];
      }
    coordinates_.push_back(coordinate);
  }
}

VectorXd ParameterSpace::parameters(const VectorXd& theta) const {
  VectorXd p = start_;
  for (Index i = 0; i < size(); ++i) {
    const Coordinate& c = at(i);
    double& value = p[c.index];
    if (c.kind == Kind::kFree) value = c.start + (c.start != 0.0 ? std::abs(c.start) : 1.0) * theta[i];
    if (c.kind == Kind::kPositive) value = c.start * std::exp(theta[i]);
    if (c.kind == Kind::kBounded) value = c.low + 0.5 * (c.high - c.low) * (1.0 + std::sin(theta[i]));
  }
  return p;
}

VectorXd ParameterSpace::slope(const VectorXd& theta) const {
  VectorXd slope(size());
  for (Index i = 0; i < size(); ++i) {
    const Coordinate& c = at(i);
    slope[i] = c.kind == Kind::kFree       ? (c.start != 0.0 ? std::abs(c.start) : 1.0)
               : c.kind == Kind::kPositive ? c.start * std::exp(theta[i])
                                           : 0.5 * (c.high - c.low) * std::cos(theta[i]);
  }
  return slope;
}

bool ParameterSpace::at_bound(Index coordinate, double value) const {
  const Coordinate& c = at(coordinate);
  const double margin = 1e-3 * (c.high - c.low);
  if (c.kind == Kind::kPositive) return value < 1e-6 * c.start;
  return c.kind == Kind::kBounded && (value < c.low + margin || value > c.high - margin);
}

}  // namespace nlo::trainer
