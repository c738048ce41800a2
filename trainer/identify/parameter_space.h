// SPDX-License-Identifier: MIT
// Parameters of a plant as the coordinates that a search may move freely.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "trainer/config/identification.h"

namespace nlo::trainer {

/// theta, n_theta, all 0 at the starting values, of unit scale there; the plant's p, n_p, of it:
///   free      p = p0 + s theta                         s = |p0|, or 1 where p0 = 0
///   positive  p = p0 exp(theta)
///   bounded   p = low + (high - low) (1 + sin theta) / 2
///   fixed     p = p0, no coordinate
class ParameterSpace {
 public:
  ParameterSpace(const PlantConfig& plant, const IdentifyConfig& identify);

  Eigen::Index size() const { return static_cast<Eigen::Index>(coordinates_.size()); }

  /// Name of the parameter behind a coordinate.
  const std::string& name(Eigen::Index coordinate) const { return at(coordinate).name; }

  /// Its place in p.
  Eigen::Index index(Eigen::Index coordinate) const { return at(coordinate).index; }

  /// p, n_p.
  Eigen::VectorXd parameters(const Eigen::VectorXd& theta) const;

  /// dp/dtheta of each coordinate, n_theta.
  Eigen::VectorXd slope(const Eigen::VectorXd& theta) const;

  /// Whether a bounded parameter is within 1e-3 of its range from an end, or a positive one has shrunk to 1e-6 of its
  /// start.
  bool at_bound(Eigen::Index coordinate, double value) const;

 private:
  enum class Kind { kFree, kPositive, kBounded };
  struct Coordinate {
    std::string name;
    Eigen::Index index;
    Kind kind;
    double start, low, high;
  };
  const Coordinate& at(Eigen::Index i) const { return coordinates_[static_cast<std::size_t>(i)]; }

  std::vector<Coordinate> coordinates_;
  Eigen::VectorXd start_;
};

}  // namespace nlo::trainer
