// SPDX-License-Identifier: MIT
// Linear rows that may replace T*, and their errors beside those of T*. shipped_model.cpp selects among them.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/learn/training/readout.h"
#include "trainer/rollout/rollout.h"
#include "trainer/rollout/sampled_truth.h"

namespace nlo::trainer {

/// The possible inputs of a linear row: the features of T*, then the outputs and inputs.
class RowInputs {
 public:
  RowInputs(const codegen::Model& model, const SampledTruth& training);

  Eigen::Index features() const { return features_; }
  Eigen::Index all() const { return of_.rows(); }
  bool has_clocks() const { return !clocks_.empty(); }
  const std::vector<int>& readings() const { return readings_; }
  /// Returns the row [intercept, columns] that copies one reading.
  Eigen::VectorXd reading_alone(std::size_t index) const;
  /// Returns the inputs of all samples, all() x N.
  Eigen::MatrixXd values(const SampledTruth& samples) const;
  /// Makes the map read the readings, too. No layer uses them yet.
  void extend(codegen::Network& map) const;

 private:
  void append(const Eigen::VectorXd& row, double mean, double deviation);

  Eigen::MatrixXd of_;
  Eigen::VectorXd mean_, scale_;
  std::vector<int> clocks_;  // as codegen::Network::feature_clocks
  Eigen::Index features_ = 0;
  std::vector<int> readings_;
};

/// A linear row for every state.
struct RowCandidate {
  Eigen::MatrixXd rows;  ///< n_x x (1 + RowInputs::all()): intercepts, then weights
  bool reads_more = false;
  bool is_constant = false;  ///< the mean of each state
  /// RMS distance between the rows and T* on training data, n_x. 0: the state wraps, so it has no fallback. Empty: not
  /// measured.
  Eigen::VectorXd distance = {};
};

/// Largest number of samples of a set on which rows are fitted and compared.
inline constexpr Eigen::Index kReadoutSamples = 150000;

/// The candidates of a model, and the training data to which they are fitted.
struct FittedRows {
  SampledTruth training;
  RowInputs inputs;
  std::vector<RowCandidate> candidates;  ///< simpler ones first
  double settled_from;                   ///< end of the transient [sample periods since the start]
};

/// Fits these candidates to samples of `training`:
///   - ridges on the features, of three strengths: first fitted on all samples, then on the settled ones
///   - the constant
///   - if a row can read outputs and inputs beside the features: the same ridges on both, then each reading alone
/// If features are multiplied by clocks, a TransientRidge takes the place of the ridges on all samples. Returns nothing
/// if no truth counts in `training`.
///   settled_from    end of the transient [sample periods since the start]
///   with_distances  RowCandidate::distance is measured, for a fallback
std::optional<FittedRows> fit_rows(const codegen::Model& model, const Rollout& training, double settled_from,
                                   bool with_distances);

/// Returns squared errors of T* and of every candidate on samples, whose weights have a sum > 0.
JudgedSet squares_of(const codegen::Model& model, const FittedRows& rows, const SampledTruth& samples);

/// Returns squares_of() on samples of `judged`. Empty if no truth counts in `judged`.
JudgedSet squares_on(const codegen::Model& model, const FittedRows& rows, const Rollout& judged);

/// Writes the selected readouts into T*: shares(i) of its last layer, plus 1 - shares(i) of row i. If reach(i) > 0, row
/// i becomes the fallback of state i.
///   reads_more   true: a row reads more than the features of T*
///   keep_hidden  true: T* keeps its hidden layers even if no state uses them
void write_readout(codegen::Network& map, const RowInputs& inputs, const Eigen::VectorXd& shares,
                   const Eigen::VectorXd& reach, const Eigen::MatrixXd& rows, bool reads_more, bool keep_hidden);

}  // namespace nlo::trainer
