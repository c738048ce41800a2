// SPDX-License-Identifier: MIT
// Measures how much of each state a latent system contains, in a fraction of a second and without training. The latent
// system is rolled out over the data with the noise of the training, and a readout in closed form shows how well z
// determines x:
//   x_hat = W [1; u; tanh(R u + r)]   u: features of T*, R and r drawn once (random features, Rahimi and Recht 2007)
// by cross-validated ridge regression. Runs of one source are left out together, and errors are geometric means over
// folds.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "trainer/base/parallel.h"
#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/rollout/rollout.h"

namespace nlo::trainer {

/// Errors on left-out data, for each state relative to its standard deviation.
struct ReadoutError {
  std::vector<double> linear;  ///< errors of W [1; u] alone
  std::vector<double> curved;  ///< with the random features
  double ridge = 0.0;          ///< ridge with the least linear errors, relative to the features' power
  int rows = 0;                ///< n_z

  /// Returns the mean over states of ln(the smaller error + 1e-3), by which banks are compared. A difference of 0.1 is
  /// ten per cent in every state.
  double mean_log() const;
};

class ReadoutProbe {
 public:
  /// `base` has the keys that determine the data: noise, mirror, seed, threads, sensors that may fail. Throws
  /// codegen::Error if no truth counts.
  ReadoutProbe(const Experiment& base, const Dataset& training);

  /// Returns the error of the best readout for the latent system and the features of `experiment`, with
  /// `random_features` tanh units at `samples` samples (at most the number drawn). The result does not depend on the
  /// number of threads.
  ReadoutError error(const Experiment& experiment, int random_features, int samples);

 private:
  struct Sample {
    int group = 0, lane = 0, time = 0, fold = 0;
  };

  void draw_segments(const Experiment& base, const Dataset& training);
  void draw_samples(const Experiment& base);
  Eigen::MatrixXd features(const Experiment& experiment, int every);

  const Dataset& dataset_;
  codegen::SensorFailures failures_;
  TrainingData data_;
  ThreadPool pool_;
  Rollout rollout_;
  std::vector<Segment> segments_;
  std::vector<int> fold_of_run_;
  bool by_block_ = false;  ///< the folds are blocks of a single log
  int folds_ = 1;
  std::vector<Sample> samples_;  ///< shuffled
  Eigen::MatrixXd states_;       ///< n_x x samples, of unit deviation
};

}  // namespace nlo::trainer
