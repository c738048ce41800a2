// SPDX-License-Identifier: MIT
// Chooses runs of a test for plots. The units of states differ, so runs are ranked by errors relative to the spread of
// each state.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <mutex>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/data/dataset.h"
#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/judge/evaluation/metrics.h"

namespace nlo::trainer {

/// Largest number of runs of a test that are kept.
inline constexpr std::size_t kMostExamples = 8;

struct Chosen {
  std::size_t run;  ///< index into the test set
  std::string why;  ///< "first", "best", "worst", "first and worst"; may be empty
};

/// Returns the root mean square of (x - x_hat) / scale over the scored samples and states of one run; angles the
/// shorter way round. NaN if no sample is scored.
double relative_error(const Trajectory& truth, const Eigen::MatrixXd& estimate, const std::vector<Channel>& states,
                      const Eigen::VectorXd& scale);

/// Returns all runs in their order. If there are more than `most` (at least 3), returns `most` of them: the first,
/// the best, the worst and others that are spread evenly over the order.
std::vector<Chosen> spread_choice(const std::vector<double>& errors, std::size_t most = kMostExamples);

/// Keeps the first run of a test and the run with the largest error, while threads estimate them in any order. The
/// result does not depend on that order.
class FirstAndWorst {
 public:
  /// `clean`, the test set, must outlive this object.
  explicit FirstAndWorst(const Dataset& clean) : clean_(clean), scale_(state_deviation(clean)) {}

  void offer(std::size_t run, Eigen::MatrixXd measured, Eigen::MatrixXd estimate);

  /// Returns the first run, then the worst, unless that is the first.
  std::vector<EvaluatedRun> take();

 private:
  struct Kept {
    std::size_t run = 0;
    double error = -1.0;  ///< -1: no run yet
    Eigen::MatrixXd measured, estimate;
  };

  const Dataset& clean_;
  Eigen::VectorXd scale_;
  std::mutex mutex_;
  Kept first_, worst_;  ///< worst_: the worst of the other runs
};

/// Returns for each of N samples 1 if z, from a reset over the measurements, is outside of the model's training domain,
/// as in_domain() of the exported observer says.
Eigen::VectorXd outside_of_domain(const codegen::Model& model, const EvaluatedRun& run, bool uniform_steps);

}  // namespace nlo::trainer
