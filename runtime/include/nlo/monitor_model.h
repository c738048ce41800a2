// SPDX-License-Identifier: MIT
// What a monitor is made of before it runs: the constants of an exported model, and the alarms it knows (monitor.h).
#pragma once

#include <cstdint>

#include "nlo/kernels/arithmetic.h"  // asks for C++20

namespace nlo {

/// What a monitor sees.
enum class Alarm : std::uint8_t {
  kNone,
  kInnovationMean,         ///< predictions are off, for longer than noise is: plant, parameters or a bias
  kInnovationVariance,     ///< more noise than in training
  kInnovationCorrelation,  ///< errors of predictions follow one another: plant or parameters
  kLatentDistance,         ///< z where training seldom was
  kMissing,                ///< too many measurements missing or beyond the gate
  kReset,                  ///< a bit of memory has flipped, the monitor's or the observer's: it begins again, not armed
};

/// Constants of a monitor, exported beside its observer's model.
template <class Scalar_, int kNx_, int kNy_, int kNz_, int kNr_, int kWindows_>
struct MonitorModel {
  using Scalar = Scalar_;
  static constexpr int kNx = kNx_, kNy = kNy_, kNz = kNz_, kNr = kNr_, kWindows = kWindows_;
  static constexpr int kFeatures = kNz + kNr + kNx;

  Scalar prediction[kNy][kFeatures];  ///< P / deviation
  Scalar offset[kNy];                 ///< c / deviation
  Scalar per_deviation[kNy];          ///< 1 / deviation
  Scalar least_variance[kNy];
  Scalar latent_mean[kNz];
  Scalar per_latent_deviation[kNz];
  Scalar gain[kWindows];  ///< a
  Scalar mean_limit[kNy][kWindows];
  Scalar variance_limit[kNy][kWindows];
  Scalar correlation_limit[kNy][kWindows];
  Scalar latent_limit[kWindows];
  Scalar missing_limit[kNy];
  Scalar gate_squared;  ///< |e| beyond the gate is an outlier
  int armed_after;      ///< samples after a start without alarm
  // A header without these has no sensor that may be frozen.
  std::uint16_t most_equal[kNy] = {};  ///< equal readings in a row, then the sensor is frozen; 0: it never is
  Scalar resting[kNy] = {};            ///< the reading that may stay the same while another output, the witness,
  std::uint8_t witness[kNy] = {};      ///< is within this range, where it is at rest, too
  Scalar rest_min[kNy] = {}, rest_max[kNy] = {};
};

/// The most that an innovation counts for, in deviations.
inline constexpr int kLargestInnovation = 5;

/// Measurements in a row that the gate keeps away; then the sensor is believed, unless it is frozen.
inline constexpr int kMostRejected = 20;

}  // namespace nlo
