// SPDX-License-Identifier: MIT
// Runs with the readings of an observer's sensors, for making and testing a monitor.
// How long an observer and its plant remember: the time scale of a monitor.
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
  std::vector<Eigen::MatrixXd> outputs;      ///< of each run, n_y x N; NaN: did not arrive
  std::vector<Eigen::MatrixXd> inputs;       ///< n_u x N; 0 x 0 without inputs
  std::vector<Eigen::VectorXd> time_s = {};  ///< N time stamps; of no run where all steps are of one sample period

  std::size_t size() const { return outputs.size(); }
  bool uniform() const { return time_s.empty(); }
  Eigen::VectorXd stamps(std::size_t run) const { return uniform() ? Eigen::VectorXd() : time_s[run]; }
};

/// `count` runs as in the training of an experiment with a [plant], parameters and inputs drawn as there: of horizon_s,
/// run i with noises[i mod their number]. The same seed, the same runs.
SensedRuns sensed_runs(const Experiment& experiment, const std::vector<NoiseConfig>& noises, double horizon_s,
                       std::uint64_t seed, int count);

/// The runs of logs, as they are.
SensedRuns sensed_runs(const Dataset& logs);

/// Runs for as long as are asked for: chunk by chunk, since hours of them need not be in memory together.
struct RunSource {
  std::function<SensedRuns(int chunk)> chunk;  ///< 0 ... chunks - 1
  int chunks = 0;
};

/// The time constant of a monitor's averages [s].
struct TimeConstant {
  double seconds = 0.0;
  std::string note = "";  ///< why it differs from that of the observer or the outputs; empty: it does not
};

/// Returns 1 / min |Re lambda| of the slowest mode that reads an output, where the latent system is linear. Otherwise
/// returns 2 pi times the outputs' correlation time (the integral of their autocorrelation up to its first zero), which
/// is the period of an oscillation, but an eighth of the longest run at most: the monitor arms after one.
/// It is at least 16 sample periods: the shortest average then spans 4 samples, and the 5 readings in a row that a gate
/// may reject are not taken for a dead sensor.
/// `recorded`: `runs` are all that there is, so it is halved until they hold 30 time constants to set limits on.
TimeConstant time_constant(const codegen::Model& model, const SensedRuns& runs, bool recorded);

}  // namespace nlo::trainer
