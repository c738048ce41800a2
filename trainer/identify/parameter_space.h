// SPDX-License-Identifier: MIT
// Parameters of a plant as unbounded coordinates for a search.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "trainer/config/identification.h"

namespace nlo::trainer {

/// Coordinates theta, n_theta, which are 0 at the start values and have unit scale there. The parameters p, n_p, of the
/// plant follow from them:
///   free      p = p0 + s theta                         s = |p0|, or 1 if p0 = 0
///   positive  p = p0 exp(theta)
///   bounded   p = low + (high - low) (1 + sin theta) / 2
///   fixed     p = p0, no coordinate
class ParameterSpace {
 public:
  ParameterSpace(const PlantConfig& plant, const IdentifyConfig& identify);

  Eigen::Index size() const { return static_cast<Eigen::Index>(coordinates_.size()); }

  /// Returns the name of the parameter of a coordinate.
  const std::string& name(Eigen::Index coordinate) const { return at(coordinate).name; }

  /// Returns the index of the parameter in p.
  Eigen::Index index(Eigen::Index coordinate) const { return at(coordinate).index; }

  /// Returns p, n_p.
  Eigen::VectorXd parameters(const Eigen::VectorXd& theta) const;

  /// Returns dp/dtheta of each coordinate, n_theta.
  Eigen::VectorXd slope(const Eigen::VectorXd& theta) const;

  /// Returns true if a bounded parameter is within 1e-3 of its range from an end, or if a positive one has shrunk to
  /// 1e-6 of its start value.
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
