// SPDX-License-Identifier: MIT
// Measures how regular the clock of a log is. Stamps that differ from an even grid by their rounding, or by a small
// jitter, count as regular: then every step is the nominal period, as in flight.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace nlo::trainer {

/// Jitter that counts as regular: the largest distance of a stamp from the grid, as a share of the period. The Qube's
/// timer has a jitter below 0.06. Whether its samples count as regular or as stamped changes the errors by less than a
/// per cent. The samples of a clock that drifts or pauses exceed this limit and count as stamped.
inline constexpr double kRegularJitter = 0.1;

/// Two regular clocks are the same if their periods agree to this share. Then no velocity has a larger error.
inline constexpr double kSamePeriod = 1e-3;

/// The grid t_0 + n_k T nearest to the stamps of a log, with integers n_k that skip missing samples.
struct TimeGrid {
  double period_s = 0.0;     ///< T by least squares over the whole log, so that nothing drifts
  double deviation_s = 0.0;  ///< largest distance of a stamp from the grid
  bool regular = false;      ///< true within the rounding of the stamps, or within kRegularJitter
  bool rounded = false;    ///< true if rounding alone explains the distances: then the grid is closer to the truth than
                           ///< the stamps
  bool complete = false;   ///< no sample is missing
  Eigen::VectorXd counts;  ///< N: n_k, from 0
};

/// Fits a grid. `time_s`: at least two samples, increasing. `resolution_s`: resolution of the printed stamps
/// (stamp_resolution), 0 if unknown.
TimeGrid fit_time_grid(const Eigen::VectorXd& time_s, double resolution_s);

/// Returns true if the grid has this period, as far as a grid of its length can show.
bool has_period(const TimeGrid& grid, double period_s);

/// Returns the largest power of ten of which all printed stamps are multiples; 0 if there is none down to 1e-9, or if
/// doubles of that size cannot show it.
double stamp_resolution(const Eigen::VectorXd& stamps);

/// Statistics of the steps between the time stamps of one file, over its runs.
struct TimeStampReport {
  std::string file;
  std::size_t runs = 1;
  Eigen::Index samples = 0;
  double duration_s = 0.0;
  double median_s = 0.0, p01_s = 0.0, p99_s = 0.0, max_s = 0.0;
  int gaps = 0;          ///< steps longer than 1.5 nominal periods
  bool nominal = false;  ///< true: each step counts as the nominal period; false: steps as stamped
};

/// Reports the stamps of one file's runs (at least one). Each `time_s` has at least two samples and increases. Steps
/// between runs do not count.
TimeStampReport report_time_stamps(const std::string& file, const std::vector<Eigen::VectorXd>& times_s,
                                   double nominal_s);

/// Returns "run.csv", or "run.csv (3 runs)".
std::string named(const TimeStampReport& report);

/// Returns the median of the steps of several logs together.
double median_step(const std::vector<Eigen::VectorXd>& times_s);

}  // namespace nlo::trainer
