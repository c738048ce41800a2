// SPDX-License-Identifier: MIT
// Features that the estimate of a state reads in the model that ships (shipped_model.h chooses them), and its errors
// beside those with other features.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

namespace nlo::trainer {

/// Errors are RMSE in the state's unit, over whole runs, or over their settled samples if these choose. On left-out
/// data they are the geometric mean over kinds of logs; otherwise the larger of the RMSE on training data as flown and
/// of that on validation data. Errors of angles go the short way round.
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
  double sensor = std::numeric_limits<double>::infinity();  ///< error of the best noisy output in its unit
  std::string sensor_name = {};                             ///< name of that output; empty: no output has the unit
};

using Readout = std::vector<StateReadout>;

/// Possible reaches of a fallback, in RMS distances of T* and row on training data.
inline constexpr std::array kReaches = {1.0, 2.0, 4.0, 8.0};

/// Mean squares of a state's errors on one set of data: of T* as trained, and of each row that may replace it.
struct StateSquares {
  double map = 0.0;
  std::vector<double> row, both;  ///< for each candidate: its squares, and its errors times those of T*
  std::vector<double> reading;    ///< squares of each output in the state's unit; infinite for others
  double deviation = 0.0;         ///< squared, of the state
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
  std::vector<SetSquares> windows;  ///< over the transient and over the settled samples; `all` alone without both
};

/// "network", "linear row", "network with fallback", or the share of the network: "0.35 network".
std::string readout_text(const StateReadout& state);

/// Describes the readouts of all states: "network: v; linear row: p; 0.35 network: w", and behind it how many groups of
/// logs chose them.
std::string readout_fact(const Readout& readout, std::size_t left_out = 0);

/// Returns the reason why the observer is no success, or nothing. The reason is a state whose error is more than 5 %
/// above that of a linear row, a constant or a sensor, and above it by more than 0.5 % of the state's standard
/// deviation.
std::string below_floor(const Readout& readout);

}  // namespace nlo::trainer
