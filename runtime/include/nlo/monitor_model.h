// SPDX-License-Identifier: MIT
// The constants of an exported monitor, and its alarms. monitor.h runs it.
#pragma once

#include <cstdint>

#include "nlo/kernels/arithmetic.h"  // asks for C++20

namespace nlo {

/// Why a monitor raises an alarm.
enum class Alarm : std::uint8_t {
  kNone,
  kInnovationMean,         ///< predictions are biased for longer than noise explains: plant, parameters or sensor bias
  kInnovationVariance,     ///< more noise than in training
  kInnovationCorrelation,  ///< successive innovations are correlated: the plant or its parameters differ
  kLatentDistance,         ///< z is in a region that training seldom reached
  kMissing,                ///< too many measurements of one output are missing, frozen or rejected by the gate
  kDisagreement,           ///< T* and its linear fit disagree: the estimate extrapolates
  kReset,  ///< memory of the monitor or of the observer is corrupted: the monitor starts again, not armed
};

/// Constants of a monitor, exported beside its observer's model. monitor.h has the equations.
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
  Scalar gate_squared;  ///< an output with e^2 above it is an outlier; kNoLimit: the gate is open
  int armed_after;      ///< samples after a start without alarm and gate; one time constant at least
  // Headers of version 0.2.0 have none of the following; zero switches each of them off.
  std::uint16_t most_equal[kNy] = {};  ///< equal readings in a row after which a sensor is frozen; 0: never
  // A sensor is at rest, and may repeat a reading for ever, if it reads `resting` while output `reference_sensor` reads
  // from rest_min to rest_max.
  Scalar resting[kNy] = {};
  std::uint8_t reference_sensor[kNy] = {};
  Scalar rest_min[kNy] = {}, rest_max[kNy] = {};
  Scalar most_moved[kNy] = {};      ///< predicted change during equal readings after which a sensor is frozen
                                    ///< [deviations]; 0: never
  Scalar motion[kNy] = {};          ///< growth of the innovation with the distance of z from its mean
  Scalar row[kNx][kNz + kNr] = {};  ///< linear fit of x_hat, divided by the deviation of T* from it
  Scalar row_offset[kNx] = {};
  Scalar per_row_deviation[kNx] = {};  ///< 1 / deviation of T* from the fit; 0: this state is not compared
  Scalar disagreement_limit[kNx] = {};
  std::uint8_t replaces[kNy] = {};  ///< 1: predictions replace missing and rejected measurements of this output
};

/// An innovation counts for at most this many deviations, so that one outlier raises no alarm.
inline constexpr int kLargestInnovation = 5;

/// From this disagreement on Monitor::widened() widens an interval. A normal difference has a mean size of 0.8.
inline constexpr int kOrdinaryDisagreement = 2;

/// The gate rejects at most this many measurements in a row, and never for longer than the monitor takes to arm. Then
/// it accepts the sensor until the innovation is ordinary again. If predictions replace missing measurements, these
/// count too; after this many in a row, further ones are not replaced. If every fifth sample is an outlier, five
/// outliers in a row occur once in 3,000 samples.
inline constexpr int kMostRejected = 5;

/// The limit of a statistic that is not watched. The statistic can reach every other limit.
inline constexpr double kNoLimit = 1e12;

}  // namespace nlo
