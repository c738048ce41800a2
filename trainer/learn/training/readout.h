// SPDX-License-Identifier: MIT
// What ships of a trained T*: for each state the map as it was trained, a linear row, or a blend of both,
//   x_hat_i = share T*_i + (1 - share) w_i . [1; u; y]
// whichever has the least error on logs that were left out of trainings like this one (left_out.h), or else on training
// data or on validation data, whatever is worse. The row is fitted when training has ended, on the features as they are
// then. So an observer is not worse there than the linear row, than a constant, or than a sensor of that state.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/rollout/rollout.h"

namespace nlo::trainer {

/// Errors are RMSE in the state's unit, on what was left out, their geometric mean over groups; or the larger of that
/// on training data as flown and that on validation data. Angles go the short way round.
struct StateReadout {
  std::string state;
  double share = 1.0;       ///< of T* as trained; the rest is the linear row
  double trained = 0.0;     ///< error of T* as trained
  double linear = 0.0;      ///< of the best linear row; infinite where z is the estimate, which no row can replace
  double shipped = 0.0;     ///< of what ships
  double validation = 0.0;  ///< of what ships, on validation data alone
  double constant = 0.0;    ///< of the state's mean over the training data
  double deviation = 0.0;   ///< the state's standard deviation
  double sensor = std::numeric_limits<double>::infinity();  ///< of the best noisy output in its unit, as it is
  std::string sensor_name = {};                             ///< of that output; empty: no output has the unit
};

using Readout = std::vector<StateReadout>;

/// Mean squares of a state's errors on one set of data: of T* as trained, and of each row that may replace it.
struct StateSquares {
  double map = 0.0;
  std::vector<double> row, both;  ///< of each candidate: its own, and its error times that of T*
  std::vector<double> reading;    ///< of each output in the state's unit as it is; infinite for others
  double deviation = 0.0;         ///< squared, of the state

  /// Of share T* + (1 - share) row.
  double blend(std::size_t candidate, double share) const;
  /// The share that makes it least, in twentieths.
  double best_share(std::size_t candidate) const;
};
using SetSquares = std::vector<StateSquares>;  ///< of each state

/// Of a model whose rows are fitted on `training`, on data that training has not seen. Empty: no truth counts there.
SetSquares left_out_squares(const codegen::Model& model, const Rollout& training, const Rollout& left_out);

/// Chooses for each state, and writes it into the model's T*. A row may read outputs and inputs that T* does not;
/// angles it reads only as T* does.
///   flight       training data as flown with the model's parameters: rows are fitted on it
///   validation   whole validation runs, with noise
///   keep_hidden  T* keeps its hidden layers though no state uses them (the error head reads the last one)
///   left_out     left_out_squares() of each group that was left out of a training; these choose. Empty: flight and
///                validation do, each candidate by the set on which it is worse: validation logs alone may be easier
///                than what was trained on, and then a row wins there that loses wherever it is harder
/// Where z is the estimate the model stays as it is, and the errors are told all the same.
Readout choose_readout(codegen::Model& model, const Rollout& flight, const Rollout& validation, bool keep_hidden,
                       const std::vector<SetSquares>& left_out = {});

/// "network", "linear row", or the share of the network: "0.35 network".
std::string share_text(double share);

/// The same of all states: "network: v; linear row: p; 0.35 network: w",
/// and behind it how many groups of logs chose it.
std::string readout_fact(const Readout& readout, std::size_t left_out = 0);

/// Empty, or the reason why the observer must not pass for a success: a state whose error is more than 5 % above that
/// of a linear row, a constant or a sensor, and above it by more than 0.5 % of the state's standard deviation.
std::string below_floor(const Readout& readout);

}  // namespace nlo::trainer
