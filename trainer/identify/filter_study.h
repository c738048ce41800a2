// SPDX-License-Identifier: MIT
// Tunes filters that know the identified plant on logs with truth. Compares their errors on test logs with those of
// estimators without a plant. A user could use one of these estimators instead of a learned observer.
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
  std::vector<LogEntry> entries;  ///< "ekf", "ukf", "constant_acceleration", LogBaseline::names(), over the test logs
  std::string tuned_on;           ///< "the validation logs", "the training logs"
  std::string judged_on;          ///< "the test logs", or the tuning logs if there are no test logs
  double sample_period_s = 0.0;
};

/// Tunes EKF and UKF of the plant with parameters `p`. The search (coordinate_search()) over process noise per state, R
/// per output and the scale of P0 minimises the sum over the logged states of RMSE / RMSE of the constant, on the
/// validation logs, or on the training logs if there are none. The search of the UKF starts at the result of the EKF.
/// If a hidden angle needs a bank of filters, the filter that starts nearest to the truth is tuned, and the bank is
/// evaluated. The q / r of the constant-acceleration filter is tuned in the same way, for each state that is a measured
/// quantity or its velocity. Ridge regression and the baselines learn from the training logs. Every estimator is
/// started at each of from_s in each log.
FilterStudy study_filters(const Identification& identification, const Eigen::VectorXd& p, const LogSplits& splits,
                          const LogSchema& schema, ThreadPool& pool, const std::atomic<bool>* stop = nullptr,
                          const StudyProgress& progress = {});

}  // namespace nlo::trainer
