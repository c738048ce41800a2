// SPDX-License-Identifier: MIT
// Multiple shooting: logs are cut into segments. Each is simulated from its own initial state, which is fitted together
// with the parameters. The initial states are eliminated segment by segment (variable projection), so that a search
// varies only the parameters.
//   r_s(p) = min over x0 of [ (y_k - h(x_k)) / sigma, k in s;  (x0 - guess) / deviation ]
//   dr_s/dp = (I - Q Q') J_p,  Q R = J_x0                       Kaufman's form of Golub and Pereyra's derivative
//   Golub, Pereyra: Separable nonlinear least squares, Inverse Problems 19 (2003)
// This is Bock's multiple shooting without matching conditions: the end of a segment need not equal the start of the
// next one. The guesses come from the logs.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "trainer/base/parallel.h"
#include "trainer/config/identification.h"
#include "trainer/data/dataset.h"
#include "trainer/identify/parameter_space.h"
#include "trainer/plants/parametric_plant.h"

namespace nlo::trainer {

/// A logged channel with which a simulation is compared.
struct FittedChannel {
  std::string name, unit;
  bool state = false;  ///< true: a logged state; false: an output
  Eigen::Index log_row = 0, plant_row = 0;
  double deviation = 1.0, wrap = 0.0;
};

/// Returns the entries of [identify] noise, found in the logs and in the plant.
std::vector<FittedChannel> fitted_channels(const Identification& identification, const Dataset& logs);

class ShootingProblem {
 public:
  /// `logs` must outlive this object. Segments of segment_s follow each other; if together they have more than
  /// most_samples samples, only every n-th is used. Throws codegen::Error if no log is as long as a segment.
  ShootingProblem(const Identification& identification, const Dataset& logs, ThreadPool& pool);
  ~ShootingProblem();

  Eigen::Index segments() const { return static_cast<Eigen::Index>(segments_.size()); }
  Eigen::Index samples() const { return samples_; }  ///< samples of all segments
  Eigen::Index rows() const { return rows_; }        ///< size of r
  const ParameterSpace& space() const { return space_; }

  /// Returns the number of residuals of measurements and unmasked truth: rows() without masked truth and without the
  /// rows of the guesses.
  Eigen::Index counted() const { return counted_; }

  /// Returns the number of initial states that the measurements determine, at the latest jacobian(). An initial state
  /// counts 0 if only its guess determines it, and 1 if the measurements do: sum over segments of |rows of Q of
  /// measurements|^2.
  double told_states() const;

  /// Returns the sum of squares of the residuals that counted() counts.
  double squares(const Eigen::VectorXd& residuals) const;

  /// Returns r at theta. NaN and infinity become a large number, so that a search turns back.
  Eigen::VectorXd residuals(const Eigen::VectorXd& theta);

  /// Returns dr/dtheta, rows() x n_theta. Later searches for initial states start at those found here.
  Eigen::MatrixXd jacobian(const Eigen::VectorXd& theta);

  /// Returns the sum over segments of (J_s' r_s)(J_s' r_s)', n_theta x n_theta, for the parameters' covariance if
  /// residuals are correlated within a segment.
  Eigen::MatrixXd scatter(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals) const;

  const std::vector<FittedChannel>& channels() const { return channels_; }

  /// RMSE of each fitted channel in its own unit, and the lag-one correlation of its residuals.
  struct ChannelError {
    double rmse = 0.0, correlation = 0.0;
  };
  std::vector<ChannelError> errors(const Eigen::VectorXd& residuals) const;

 private:
  struct Segment {
    const Trajectory* run = nullptr;
    Eigen::Index first = 0, samples = 0, row = 0;
    Eigen::VectorXd guess, start;  ///< n_x: guess from the logs, and start of the search for the initial state
    double told = 0.0;             ///< part of told_states()
  };
  class Worker;

  Eigen::VectorXd guess_of(const Trajectory& run, Eigen::Index sample) const;
  Eigen::Index rows_of(const Segment& segment) const;

  const Identification& identification_;
  ThreadPool& pool_;
  ParameterSpace space_;
  std::vector<FittedChannel> channels_;
  std::vector<Segment> segments_;
  std::vector<std::unique_ptr<Worker>> workers_;        ///< one per thread
  std::vector<std::pair<bool, Eigen::Index>> guesses_;  ///< per state: true for a logged state, false for an output;
                                                        ///< and its row, -1: none
  std::vector<Eigen::Index> input_rows_;
  Eigen::Index rows_ = 0, samples_ = 0, counted_ = 0, free_ = 0;
};

}  // namespace nlo::trainer
