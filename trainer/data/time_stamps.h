// SPDX-License-Identifier: MIT
// How regular the clock of a log is. Stamps that differ from an even grid by their rounding, or by a small jitter,
// count as regular: then every step is the nominal period, as it will be in flight.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace nlo::trainer {

/// Jitter that counts as regular: the largest distance of a stamp from the grid, as a share of the period. The Qube's
/// timer stays within 0.06, and its errors are the same to a per cent either way; a clock that wanders or pauses leaves
/// the grid by more and is taken as stamped.
inline constexpr double kRegularJitter = 0.1;

/// Two regular clocks are the same when their periods agree to this: no velocity is wrong by more.
inline constexpr double kSamePeriod = 1e-3;

/// The grid t_0 + n_k T nearest to a log's stamps, with whole numbers n_k that leave out missing samples.
struct TimeGrid {
  double period_s = 0.0;     ///< T by least squares over the whole log, so that nothing drifts
  double deviation_s = 0.0;  ///< largest distance of a stamp from the grid
  bool regular = false;      ///< within the rounding of the stamps, or within kRegularJitter
  bool rounded = false;      ///< rounding alone explains the distances: the grid is nearer to the truth than the stamps
  bool complete = false;     ///< no sample is missing
  Eigen::VectorXd counts;    ///< N: n_k, from 0
};

/// `time_s`: at least two samples, increasing. `resolution_s`: of the printed stamps (stamp_resolution), 0 when
/// unknown.
TimeGrid fit_time_grid(const Eigen::VectorXd& time_s, double resolution_s);

/// Same period, as far as grids of their lengths can tell.
bool has_period(const TimeGrid& grid, double period_s);

/// The largest power of ten that all stamps, as they stand in the file, are multiples of; 0 when there is none down to
/// 1e-9, or when doubles of that size cannot tell.
double stamp_resolution(const Eigen::VectorXd& stamps);

/// Statistics of the steps between the time stamps of one file, over its runs.
struct TimeStampReport {
  std::string file;
  std::size_t runs = 1;
  Eigen::Index samples = 0;
  double duration_s = 0.0;
  double median_s = 0.0, p01_s = 0.0, p99_s = 0.0, max_s = 0.0;
  int gaps = 0;          ///< steps longer than 1.5 nominal periods
  bool nominal = false;  ///< each step counts as the nominal period; else as it is stamped
};

/// Reports the stamps of one file's runs (at least one). Each `time_s` has at least two samples and increases. Steps
/// between runs do not count.
TimeStampReport report_time_stamps(const std::string& file, const std::vector<Eigen::VectorXd>& times_s,
                                   double nominal_s);

/// "run.csv", or "run.csv (3 runs)".
std::string named(const TimeStampReport& report);

/// Median of the steps of several logs taken together.
double median_step(const std::vector<Eigen::VectorXd>& times_s);

}  // namespace nlo::trainer
