// SPDX-License-Identifier: MIT
// Strict measurement noise for evaluation: y_k = h(x_k) + v_k, one independent draw per sample and channel. It uses a
// simple scalar generator that anyone can implement from this description; training uses its own, faster generator.
//
// Run i of a test with seed s draws from std::mt19937_64 seeded by mix(s, i) (two rounds of SplitMix64), sensor by
// sensor within a sample, sample after sample. A sensor without noise draws nothing:
//   u       = (r >> 11) * 2^-53 of the next 64 bits r, in [0, 1)
//   uniform = scale * (2 u - 1)
//   normal  = Marsaglia's polar method: v = 2 u - 1 twice until 0 < q = v1^2 + v2^2 < 1; then v1 and v2 times scale *
//   sqrt(-2 ln q / q) are two draws, used one after the other
//   student = scale * n / sqrt((n_1^2 + ... + n_f^2) / f) of f + 1 normal draws of scale 1, n first
// Then, for a sensor with outliers: an outlier if u < share, of size amplitude * (2 u - 1) by the next u. Biases are
// uniform and drawn before the first sample, sensor by sensor. Clipping and quantising come last. Times and outages of
// measurements come from a second engine, seeded by mix(s ^ 0x74696d65, i), so that they change no noise. Its draws
// are: the common part of the sensors' biases; the delays of sensors with a range of delays; then for each sample one
// uniform number that the jitters of all sensors share (the loop's clock jitters), and one for each kind of outage
// (missing, stuck, dead) of each sensor that has it. Each run has its own stream, so neither the number of threads nor
// the number of runs changes a draw.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "trainer/base/noise_table.h"
#include "trainer/data/angle.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

class MeasurementNoise final : private NoiseNumbers<double> {
 public:
  MeasurementNoise(const NoiseConfig& config, std::uint64_t seed, std::uint64_t run);

  /// Draws the noise of one sensor (any sensor if the noise is the same for all).
  double draw(std::size_t sensor = 0);

  /// Returns the outputs (n_y x N) as sensors with this noise measure them. `angles`: the outputs that are sine and
  /// cosine of one angle (Dataset::output_angles); they have one sensor, and its noise is added to the angle. A sample
  /// that does not arrive is NaN, as for an observer in flight.
  Eigen::MatrixXd on(const Eigen::MatrixXd& outputs, const std::vector<EncodedAngle>& angles = {});

 private:
  /// Returns y at the instants of the measurements, by cubics between samples.
  Eigen::MatrixXd when_measured(const Eigen::MatrixXd& outputs, const std::vector<EncodedAngle>& angles);
  void fail_sensors(Eigen::MatrixXd& noisy, const std::vector<EncodedAngle>& angles);
  double uniform01();
  double uniform() override;
  double normal() override;
  void normals(std::span<double> all) override;

  NoiseConfig config_;
  std::mt19937_64 engine_, timing_;
  std::vector<double> biases_;  ///< bias of each sensor
  double spare_normal_ = 0.0;
  bool has_spare_ = false;
};

/// Replaces NaN by each output's last value, for filters that need numbers.
Eigen::MatrixXd held(Eigen::MatrixXd outputs);
Dataset held(Dataset runs);

/// Returns the outputs of each run i with the noise of seed and i.
Dataset with_noise(Dataset runs, const NoiseConfig& noise, std::uint64_t seed);

/// Returns the noise without delays and jitter, for a closed loop whose sensors measure on request.
NoiseConfig without_shifts(NoiseConfig noise);

/// Returns the nominal variance: scale^2 (Gaussian and Student's t), scale^2 / 3 (uniform), or 0, without outliers and
/// the like.
double noise_variance(const SensorNoise& noise);

/// Returns one variance for all sensors, or one for each.
Eigen::VectorXd noise_variances(const NoiseConfig& noise);

/// Returns a text for readers: "no noise", "N(0, 0.5)", "U(-3, 3)"; several sensors one after another.
std::string noise_title(const NoiseConfig& noise);
std::string sensor_title(const SensorNoise& noise);

}  // namespace nlo::trainer
