// SPDX-License-Identifier: MIT
// Which runs of a test are worth a plot. States differ in unit, so runs are ranked by errors in shares of each state's
// own spread.
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

/// How many runs of a test are kept at most.
inline constexpr std::size_t kMostExamples = 8;

struct Chosen {
  std::size_t run;  ///< index into the test set
  std::string why;  ///< "first", "best", "worst", "first and worst"; may be empty
};

/// Root mean square of (x - x_hat) / scale over the scored samples and states of one run; angles the short way round.
/// NaN when no sample is scored.
double relative_error(const Trajectory& truth, const Eigen::MatrixXd& estimate, const std::vector<Channel>& states,
                      const Eigen::VectorXd& scale);

/// All runs in their order; of more than `most` (at least 3) the first, the best, the worst and as many others, evenly
/// spread over the order.
std::vector<Chosen> spread_choice(const std::vector<double>& errors, std::size_t most = kMostExamples);

/// Keeps the first run of a test and the one with the largest error, while threads estimate them in any order: which
/// ones these are does not depend on that order.
class FirstAndWorst {
 public:
  /// `clean`, the test set, outlives this object.
  explicit FirstAndWorst(const Dataset& clean) : clean_(clean), scale_(state_deviation(clean)) {}

  void offer(std::size_t run, Eigen::MatrixXd measured, Eigen::MatrixXd estimate);

  /// The first, then the worst unless that is the first.
  std::vector<EvaluatedRun> take();

 private:
  struct Kept {
    std::size_t run = 0;
    double error = -1.0;  ///< none yet
    Eigen::MatrixXd measured, estimate;
  };

  const Dataset& clean_;
  Eigen::VectorXd scale_;
  std::mutex mutex_;
  Kept first_, worst_;  ///< worst_: of the others
};

/// N: 1 where z, from reset over the measurements, is outside of the model's training domain, as in_domain() of the
/// exported observer says.
Eigen::VectorXd outside_of_domain(const codegen::Model& model, const EvaluatedRun& run, bool uniform_steps);

}  // namespace nlo::trainer
