// SPDX-License-Identifier: MIT
// Sampled trajectories of a plant, simulated or logged, for training and evaluation. Other parts of the trainer do not
// know where samples come from.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "codegen/model/computed_outputs.h"
#include "codegen/model/model.h"
#include "trainer/data/angle.h"
#include "trainer/data/mirror.h"

namespace nlo::trainer {

using codegen::Channel;

/// One run of a plant, N samples. Angles (channels with a wrap) are unwrapped along the run.
struct Trajectory {
  std::string source;       ///< a file name, or "simulation 17"
  Eigen::VectorXd time_s;   ///< N, strictly increasing, from the first sample; a lead-in (lead_in.h) has t < 0
  Eigen::MatrixXd outputs;  ///< n_y x N; noise-free in simulations, measured in logs
  Eigen::MatrixXd states;   ///< n_x x N, the truth to learn
  Eigen::VectorXd weight;   ///< N: 1 if the truth counts, 0 if it is masked (edges of a zero-phase filter)
  /// Index of the first sample with an estimate. Before it the latent state only settles (a dropped transient, a
  /// lead-in); neither training nor flight requires an estimate there.
  Eigen::Index first_estimate = 0;
  Eigen::MatrixXd derivatives = {};  ///< n_x x N, f(x), if the PDE residual needs it; else 0 x 0
  Eigen::MatrixXd inputs = {};       ///< n_u x N, excitation of the plant; 0 x 0 without inputs
  Eigen::MatrixXd unestimated = {};  ///< rows x N, states of a simulated plant that nobody estimates; else 0 x 0
  /// n_y x N: true if the log has no measurement (an empty cell); `outputs` then holds the last one. 0 x 0: all are
  /// measured.
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> missing = {};
  std::string log = {};  ///< path of the log of this run; gaps split a log into several runs

  Eigen::Index samples() const { return time_s.size(); }
  /// Returns the outputs as an observer gets them in flight: NaN if they are missing.
  Eigen::MatrixXd measured() const {
    if (missing.size() == 0) return outputs;
    return missing.select(std::numeric_limits<double>::quiet_NaN(), outputs.array()).matrix();
  }
  /// Returns every `every`-th sample from `first` on; time starts at 0 there.
  Trajectory from(Eigen::Index first, Eigen::Index every = 1) const;
};

/// Points of the state space with f and h of the plant, for the PDE residual.
struct Collocation {
  Eigen::MatrixXd x, f, h;  ///< n_x, n_x, n_y x count; 0 x 0 if they are not needed
};

struct Dataset {
  std::vector<Channel> outputs;
  std::vector<Channel> states;
  double sample_period_s = 0.0;  ///< nominal
  bool uniform = true;  ///< true: every step is sample_period_s (simulations); false: steps follow from time_s (logs)
  std::vector<Trajectory> trajectories;
  Collocation collocation = {};
  codegen::DenseLayer input_field = {};          ///< g of the plant of a driven observer, as in codegen::Drive
  std::vector<Channel> inputs = {};              ///< inputs; empty if the plant has none
  bool reads_inputs = false;                     ///< true if the observer reads the inputs beside the outputs
  std::vector<EncodedAngle> output_angles = {};  ///< angles among the outputs, in order; noise is added to the angle
  Mirror mirror = {};                            ///< signs of readings() and states in a mirror image
  double simulated_share = 0.0;  ///< share of a step's segments from simulated runs, which are the last trajectories

  /// Returns the inputs that the observer reads beside the outputs.
  std::vector<Channel> inputs_read() const { return reads_inputs ? inputs : std::vector<Channel>{}; }

  /// Returns the readings of the latent system and T*: outputs, then the inputs that are read.
  std::vector<Channel> readings() const {
    std::vector<Channel> both = outputs;
    if (reads_inputs) both.insert(both.end(), inputs.begin(), inputs.end());
    return both;
  }

  /// Returns the number of measured quantities. An angle that is given as sine and cosine counts once.
  std::size_t sensors() const {
    return static_cast<std::size_t>(codegen::measured_outputs(outputs)) - output_angles.size();
  }

  /// Returns the latest time stamp of all runs [s]; 0 if there is no sample.
  double longest_s() const;

  /// Computes outputs from the current values of other outputs and inputs. An output is missing if one of them is
  /// missing.
  void compute_outputs();
};

inline std::vector<std::string> channel_names(const std::vector<codegen::Channel>& channels) {
  std::vector<std::string> names;
  for (const codegen::Channel& channel : channels) names.push_back(channel.name);
  return names;
}

}  // namespace nlo::trainer
