// SPDX-License-Identifier: MIT
// Filters that know the identified plant, tuned on logs with truth, and estimators without a plant: their errors on
// test logs. A user could take them instead of a learned observer.
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <string>
#include <vector>

#include "trainer/base/coordinate_search.h"
#include "trainer/base/parallel.h"
#include "trainer/config/identification.h"
#include "trainer/data/log_dataset.h"
#include "trainer/data/log_schema.h"
#include "trainer/judge/evaluation/evaluate_logs.h"

namespace nlo::trainer {

struct FilterStudy {
  std::vector<LogEntry> entries;  ///< "ekf", "ukf", "constant_acceleration", LogBaseline::names(): over the test logs
  std::string tuned_on;           ///< "the validation logs", "the training logs"
  std::string judged_on;          ///< "the test logs", or without them the tuning logs
  double sample_period_s = 0.0;
};

/// EKF and UKF of the plant with parameters `p`: process noise per state, R per output and the scale of P0 are searched
/// (coordinate_search()) for the least sum over the logged states of RMSE / RMSE of the constant, on the validation
/// logs, or on the training logs where there are none. The UKF's search starts where the EKF's ended. Where a hidden
/// angle takes a bank of filters, that one is tuned which starts nearest to the truth, and the bank is judged. The
/// constant-acceleration filter's q / r likewise, for each state that is a measured quantity or its velocity. Ridge
/// regression and the baselines learn from the training logs. All start at each of from_s in each log.
FilterStudy study_filters(const Identification& identification, const Eigen::VectorXd& p, const LogSplits& splits,
                          const LogSchema& schema, ThreadPool& pool, const std::atomic<bool>* stop = nullptr,
                          const StudyProgress& progress = {});

}  // namespace nlo::trainer
