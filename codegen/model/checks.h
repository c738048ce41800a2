// SPDX-License-Identifier: MIT
// Checks that validation is made of. Each throws Error that names the field, what is wrong and what to do.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "codegen/base/fail.h"
#include "codegen/model/model.h"

namespace nlo::codegen {

/// `m` is rows x cols and finite; `meaning` says what the sizes are.
void check_shape(const Eigen::MatrixXd& m, Eigen::Index rows, Eigen::Index cols, const std::string& field,
                 const char* meaning);
void check_shape(const Eigen::VectorXd& v, Eigen::Index size, const std::string& field, const char* meaning);

/// Every entry of a scale is positive.
void check_positive(const Eigen::VectorXd& v, const std::string& field);

/// FIELD_min is below FIELD_max, entry by entry, and float holds both.
void check_range(const Eigen::VectorXd& low, const Eigen::VectorXd& high, const char* field);

/// Channels that can be named in code, each by another name.
void check_channels(const std::vector<Channel>& channels, const std::string& field);

/// A network from `inputs` (described by `meaning`) to `outputs` that is whole and finite.
void check_network(const Network& network, int inputs, int outputs, const std::string& field, const char* meaning);

/// What no number of a state or a sum may pass: a step or an estimate of it stays below float's 3.4e38, and above it
/// (2^100) the runtime takes z for spoilt (nlo/observer_state.h).
constexpr double kLargestNumber = 1e30, kSmallestNumber = 1e-30;

/// No sum of the network leaves the numbers of float, as long as its inputs stay within +-`largest`.
void check_sums(const Network& network, const Eigen::VectorXd& largest, const std::string& field);

/// How the features of T* change with whole turns of an output, where rounding alone does not explain it: feature and
/// change per unit. Empty: T* knows the output only through z - S y. For models with a linear latent system.
struct SeenChange {
  Eigen::Index feature;
  double change;
};
std::vector<SeenChange> seen_of_turn(const Model& model, int output);

/// The largest |reading| that validation lets pass, n_r: of one that wraps, a turn beyond its range.
Eigen::VectorXd largest_readings(const Model& model);

/// No output is an angle that is continued over its wrap: what has no steady state S cannot turn z with it.
void check_no_angles(const Model& model);

}  // namespace nlo::codegen
