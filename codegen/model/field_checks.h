// SPDX-License-Identifier: MIT
// Checks of model fields. Each throws Error with the name of the field, the mistake and the fix.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "codegen/base/fail.h"
#include "codegen/model/model.h"

namespace nlo::codegen {

/// Requires that `m` is rows x cols and finite. `meaning` explains the sizes in the error.
void check_shape(const Eigen::MatrixXd& m, Eigen::Index rows, Eigen::Index cols, const std::string& field,
                 const char* meaning);
void check_shape(const Eigen::VectorXd& v, Eigen::Index size, const std::string& field, const char* meaning);

/// Requires that every entry of a scale is positive.
void check_positive(const Eigen::VectorXd& v, const std::string& field);

/// Requires that FIELD_min is below FIELD_max, entry by entry, and that float can hold both.
void check_range(const Eigen::VectorXd& low, const Eigen::VectorXd& high, const char* field);

/// Requires that the names of channels are identifiers and differ from each other.
void check_channels(const std::vector<Channel>& channels, const std::string& field);

/// Requires a complete and finite network from `inputs` (explained by `meaning`) to `outputs`.
void check_network(const Network& network, int inputs, int outputs, const std::string& field, const char* meaning);

/// Largest number of a state or a sum. Up to it, a step or an estimate stays below 3.4e38, the limit of float. Above it
/// (2^100) the runtime considers z corrupted (nlo/observer_state.h).
constexpr double kLargestNumber = 1e30, kSmallestNumber = 1e-30;

/// Requires that no sum of the network overflows in float if its inputs are within +-`largest`.
void check_sums(const Network& network, const Eigen::VectorXd& largest, const std::string& field);

/// Returns the features of T* that whole turns of an output change by more than rounding, with the change per unit.
/// Empty if T* reads the output only through z - S y. The model must have a linear latent system.
struct SeenChange {
  Eigen::Index feature;
  double change;
};
std::vector<SeenChange> seen_of_turn(const Model& model, int output);

/// Returns the largest |reading| after validation, n_r. For a reading that wraps it is one turn beyond its range.
Eigen::VectorXd largest_readings(const Model& model);

/// Requires that no output is an angle that is unwrapped. A structure without a steady state S cannot change z with it.
void check_no_angles(const Model& model);

}  // namespace nlo::codegen
