// SPDX-License-Identifier: MIT
// Runs with the readings of an observer's sensors, for making and testing a monitor. time_constant() derives the time
// scale of a monitor from the memory of the observer and the plant.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/base/noise.h"
#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

struct SensedRuns {
  std::vector<Eigen::MatrixXd> outputs;      ///< one matrix for each run, n_y x N; NaN: did not arrive
  std::vector<Eigen::MatrixXd> inputs;       ///< n_u x N; 0 x 0 without inputs
  std::vector<Eigen::VectorXd> time_s = {};  ///< N time stamps; empty if all steps are one sample period

  std::size_t size() const { return outputs.size(); }
  bool uniform() const { return time_s.empty(); }
  Eigen::VectorXd stamps(std::size_t run) const { return uniform() ? Eigen::VectorXd() : time_s[run]; }
};

/// Makes `count` runs like those of the training of an experiment with a [plant], with parameters and inputs drawn in
/// the same way, over horizon_s. Run i has noises[i mod their number]. The same seed gives the same runs.
SensedRuns sensed_runs(const Experiment& experiment, const std::vector<NoiseConfig>& noises, double horizon_s,
                       std::uint64_t seed, int count);

/// Returns the runs of logs, unchanged.
SensedRuns sensed_runs(const Dataset& logs);

/// Makes runs on request, chunk by chunk, because hours of them need not be in memory together.
struct RunSource {
  std::function<SensedRuns(int chunk)> chunk;  ///< 0 ... chunks - 1
  int chunks = 0;
};

/// The time constant of a monitor's averages [s].
struct TimeConstant {
  double seconds = 0.0;
  std::string note = "";  ///< reason if it differs from that of the observer or the outputs; else empty
};

/// Returns 1 / min |Re lambda| of the slowest mode that reads an output, if the latent system is linear. Otherwise
/// returns 2 pi times the correlation time of the outputs (the integral of their autocorrelation up to its first zero),
/// which is the period of an oscillation. It is then at most an eighth of the longest run, because the monitor arms
/// after one time constant. In all cases it is at least 16 sample periods: the shortest average then spans 4 samples,
/// and 5 rejected readings in a row do not look like a dead sensor. `recorded`: there are no other runs, so the time
/// constant is halved until they contain 30 of them for the limits.
TimeConstant time_constant(const codegen::Model& model, const SensedRuns& runs, bool recorded);

}  // namespace nlo::trainer
