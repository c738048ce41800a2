// SPDX-License-Identifier: MIT
// Sampled trajectories of a plant, simulated or logged, for training and evaluation. No other part of the trainer
// knows the origin of samples.
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

/// One run of a plant, N samples. Angles (channels with a wrap) are unwrapped along the run: no jumps.
struct Trajectory {
  std::string source;       ///< a file name, or "simulation 17"
  Eigen::VectorXd time_s;   ///< N, strictly increasing, from the first sample; a lead-in (lead_in.h) has t < 0
  Eigen::MatrixXd outputs;  ///< n_y x N, noise-free when simulated, as measured when logged
  Eigen::MatrixXd states;   ///< n_x x N, the truth to learn
  Eigen::VectorXd weight;   ///< N: 1 where the truth counts, 0 where it is masked (edges of a zero-phase filter)
  /// Before it the latent state only settles (a dropped transient, a lead-in): no estimate is asked for there, in
  /// training or in flight.
  Eigen::Index first_estimate = 0;
  Eigen::MatrixXd derivatives = {};  ///< n_x x N, f(x): where the PDE residual asks for it; else 0 x 0
  Eigen::MatrixXd inputs = {};       ///< n_u x N, excitation of the plant; 0 x 0 without inputs
  /// n_y x N: whether a log has no measurement there (an empty cell): `outputs` then holds the last one.
  /// 0 x 0: it has all.
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> missing = {};
  std::string log = {};  ///< path of the log that it is a run of; gaps make several of one

  Eigen::Index samples() const { return time_s.size(); }
  /// The outputs as an observer in flight is given them: NaN where they are missing.
  Eigen::MatrixXd measured() const {
    if (missing.size() == 0) return outputs;
    return missing.select(std::numeric_limits<double>::quiet_NaN(), outputs.array()).matrix();
  }
  /// Every `every`-th sample from `first` on; time counts from there.
  Trajectory from(Eigen::Index first, Eigen::Index every = 1) const;
};

/// Points of the state space with the plant's f and h there: where the PDE residual asks for them.
struct Collocation {
  Eigen::MatrixXd x, f, h;  ///< n_x, n_x, n_y x count; 0 x 0 when nothing does
};

struct Dataset {
  std::vector<Channel> outputs;
  std::vector<Channel> states;
  double sample_period_s = 0.0;  ///< nominal
  bool uniform = true;           ///< every step is sample_period_s (simulations); else steps come from time_s (logs)
  std::vector<Trajectory> trajectories;
  Collocation collocation = {};
  codegen::DenseLayer input_field = {};  ///< g of a plant that a driven observer is trained for, as in codegen::Drive
  std::vector<Channel> inputs = {};      ///< empty when nothing excites the plant
  bool reads_inputs = false;             ///< the observer reads them beside the outputs
  std::vector<EncodedAngle> output_angles = {};  ///< among the outputs, in order: noise is on the angle
  Mirror mirror = {};                            ///< signs of readings() and states
  double simulated_share = 0.0;  ///< share of a step's segments from simulated runs, which stand behind all others

  /// The inputs that the observer reads beside the outputs.
  std::vector<Channel> inputs_read() const { return reads_inputs ? inputs : std::vector<Channel>{}; }

  /// Readings of the latent system and T*: outputs, then the inputs that are read.
  std::vector<Channel> readings() const {
    std::vector<Channel> both = outputs;
    if (reads_inputs) both.insert(both.end(), inputs.begin(), inputs.end());
    return both;
  }

  /// How many quantities are measured: an angle as sine and cosine is one.
  std::size_t sensors() const {
    return static_cast<std::size_t>(codegen::measured_outputs(outputs)) - output_angles.size();
  }

  /// The latest time stamp of all runs [s]; 0 without a sample.
  double longest_s() const;

  /// Computes outputs from the current values of other outputs and inputs; missing where one of them is.
  void compute_outputs();
};

inline std::vector<std::string> channel_names(const std::vector<codegen::Channel>& channels) {
  std::vector<std::string> names;
  for (const codegen::Channel& channel : channels) names.push_back(channel.name);
  return names;
}

}  // namespace nlo::trainer
