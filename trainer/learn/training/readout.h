// SPDX-License-Identifier: MIT
// The features that the shipped model reads to estimate a state (chosen by shipped_model.h), and the errors with these
// and with other features.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

namespace nlo::trainer {

/// Readout of one state and its errors. An error is an RMSE in the state's unit over whole runs, or over their settled
/// samples if these choose the readout. On left-out data it is the geometric mean over kinds of logs; otherwise it is
/// the larger RMSE of training data (run as in flight) and validation data. An angle's error is the shorter way round.
struct StateReadout {
  std::string state;
  double share = 1.0;       ///< share of T* as trained; the rest is the linear row
  double reach = 0.0;       ///< reach of its fallback (codegen::Fallback); 0: no fallback
  double trained = 0.0;     ///< error of T* as trained
  double linear = 0.0;      ///< error of the best linear row; infinite if z is the estimate, which no row can replace
  double shipped = 0.0;     ///< error of the shipped readout
  double validation = 0.0;  ///< error of the shipped readout on validation data alone
  double constant = 0.0;    ///< error of the state's mean over the training data
  double deviation = 0.0;   ///< the state's standard deviation
  double sensor = std::numeric_limits<double>::infinity();  ///< smallest error of a noisy output in the state's unit
  std::string sensor_name = {};                             ///< name of that output; empty: no output has the unit
};

using Readout = std::vector<StateReadout>;

/// Possible reaches of a fallback, in RMS distances of T* and row on training data.
inline constexpr std::array kReaches = {1.0, 2.0, 4.0, 8.0};

/// Mean squares of a state's errors on one set of data: of T* as trained, and of each row that may replace it.
struct StateSquares {
  double map = 0.0;
  std::vector<double> row, both;  ///< for each candidate: its squares, and its errors times those of T*
  std::vector<double> reading;    ///< squared errors of each output in the state's unit; infinite for other outputs
  double deviation = 0.0;         ///< variance of the state
  /// Squares of T* that falls back to a row, for each candidate and each reach of kReaches. Infinite if the
  /// distance of T* and row is unknown (RowCandidate::distance is 0).
  std::vector<std::array<double, kReaches.size()>> fallback;

  /// Squares of share T* + (1 - share) row.
  double blend(std::size_t candidate, double share) const;
};
using SetSquares = std::vector<StateSquares>;  ///< one for each state

/// Squared errors on one set of data.
struct JudgedSet {
  std::string kind = {};            ///< kind of the logs that were left out (log_files.h)
  SetSquares all;                   ///< over all samples
  std::vector<SetSquares> windows;  ///< over the transient and over the settled samples; or `all` as the only one
};

/// "network", "linear row", "network with fallback", or the share of the network: "0.35 network".
std::string readout_text(const StateReadout& state);

/// Describes the readouts of all states, followed by the number of groups of logs that chose them: "network: v; linear
/// row: p; 0.35 network: w (by 4 groups of logs that were left out)".
std::string readout_fact(const Readout& readout, std::size_t left_out = 0);

/// Returns a text if the observer is worse than a simple estimate, else an empty text. It is worse if the error of a
/// state exceeds that of a linear row, a constant or a sensor by more than 5 %, and also by more than 0.5 % of the
/// state's standard deviation.
std::string below_floor(const Readout& readout);

}  // namespace nlo::trainer
