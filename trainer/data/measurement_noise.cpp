// SPDX-License-Identifier: MIT
#include "trainer/data/measurement_noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "codegen/base/splitmix.h"
#include "trainer/base/engine_draws.h"
#include "trainer/base/interpolate.h"
#include "trainer/base/noise_table.h"
#include "trainer/base/number_text.h"
#include "trainer/base/sensor_reading.h"

namespace nlo::trainer {
namespace {

/// Mixes a seed, so that neighbouring seeds give unrelated numbers.
std::uint64_t scattered(std::uint64_t seed) {
  return codegen::splitmix64(seed);
}

/// Returns the sensor of each row; sine and cosine of an angle have the same sensor.
std::vector<std::size_t> sensors_of(Eigen::Index rows, const std::vector<EncodedAngle>& angles) {
  std::vector<std::size_t> sensors;
  auto angle = angles.begin();
  std::size_t sensor = 0;
  while (static_cast<Eigen::Index>(sensors.size()) < rows) {
    if (angle != angles.end() && angle->sine == static_cast<Eigen::Index>(sensors.size())) {
      sensors.push_back(sensor);
      ++angle;
    }
    sensors.push_back(sensor++);
  }
  return sensors;
}

}  // namespace

MeasurementNoise::MeasurementNoise(const NoiseConfig& config, std::uint64_t seed, std::uint64_t run)
    : config_(config),
      engine_(scattered(scattered(seed) + run)),
      timing_(scattered(scattered(seed ^ 0x74696d65ULL) + run)) {
  for (const SensorNoise& sensor : config_.sensors)
    biases_.push_back(sensor.bias > 0.0 ? sensor.bias * uniform() : 0.0);
  if (std::ranges::none_of(config_.sensors, [](const SensorNoise& own) { return own.common_bias > 0.0; })) return;
  const double common = 2.0 * trainer::uniform01(timing_) - 1.0;
  for (std::size_t i = 0; i < biases_.size(); ++i) biases_[i] += config_.sensors[i].common_bias * common;
}

double MeasurementNoise::uniform01() {
  return trainer::uniform01(engine_);
}

double MeasurementNoise::uniform() {
  return 2.0 * uniform01() - 1.0;
}

void MeasurementNoise::normals(std::span<double> all) {
  for (double& each : all) each = normal();
}

double MeasurementNoise::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_normal_;
  }
  const auto [first, second] = normal_pair(engine_);
  spare_normal_ = second;
  has_spare_ = true;
  return first;
}

double MeasurementNoise::draw(std::size_t sensor) {
  const SensorNoise& own = config_.of(sensor);
  double v = own.scale * noise_row(own.kind).draw(*this, own.shape) + biases_[config_.sensors.size() == 1 ? 0 : sensor];
  if (own.outlier_share > 0.0 && uniform01() < own.outlier_share) v += own.outlier_amplitude * uniform();
  return v;
}

Eigen::MatrixXd MeasurementNoise::on(const Eigen::MatrixXd& outputs, const std::vector<EncodedAngle>& angles) {
  Eigen::MatrixXd noisy = config_.shifted() ? when_measured(outputs, angles) : outputs;
  for (Eigen::Index k = 0; k < noisy.cols(); ++k) {
    auto angle = angles.begin();
    std::size_t sensor = 0;
    for (Eigen::Index row = 0; row < noisy.rows(); ++row) {
      const SensorNoise& own = config_.of(sensor);
      const double v = draw(sensor++);
      if (angle == angles.end() || angle->sine != row) {
        noisy(row, k) = reading_of(own, noisy(row, k) + v);
        continue;
      }
      const double radians = 2.0 * std::numbers::pi * v / angle->wrap;
      const double sine = noisy(row, k), cosine = noisy(row + 1, k), s = std::sin(radians), c = std::cos(radians);
      noisy(row, k) = sine * c + cosine * s;
      noisy(row + 1, k) = cosine * c - sine * s;
      if (clips_or_rounds(own)) read_angle(own, angle->wrap, noisy(row, k), noisy(row + 1, k));
      ++row;
      ++angle;
    }
  }
  if (config_.fails()) fail_sensors(noisy, angles);
  return noisy;
}

Eigen::MatrixXd MeasurementNoise::when_measured(const Eigen::MatrixXd& outputs,
                                                const std::vector<EncodedAngle>& angles) {
  const std::vector<std::size_t> sensors = sensors_of(outputs.rows(), angles);
  std::vector<double> delays;
  for (std::size_t sensor = 0; !sensors.empty() && sensor <= sensors.back(); ++sensor) {
    const SensorNoise& own = config_.of(sensor);
    const bool drawn = own.delay_low < own.delay_high;
    delays.push_back(own.delay_low + (drawn ? (own.delay_high - own.delay_low) * trainer::uniform01(timing_) : 0.0));
  }
  const bool jitters = std::any_of(config_.sensors.begin(), config_.sensors.end(),
                                   [](const SensorNoise& own) { return own.jitter > 0.0; });
  Eigen::MatrixXd shifted = outputs;
  for (Eigen::Index k = 0; k < outputs.cols(); ++k) {
    const double off = jitters ? 2.0 * trainer::uniform01(timing_) - 1.0 : 0.0;
    for (Eigen::Index row = 0; row < outputs.rows(); ++row) {
      const std::size_t sensor = sensors[static_cast<std::size_t>(row)];
      const SensorNoise& own = config_.of(sensor);
      if (own.shifted())
        shifted(row, k) = cubic_at<double>([&](Eigen::Index at) { return outputs(row, at); }, outputs.cols(),
                                           static_cast<double>(k) - delays[sensor] + own.jitter * off);
    }
  }
  return shifted;
}

void MeasurementNoise::fail_sensors(Eigen::MatrixXd& noisy, const std::vector<EncodedAngle>& angles) {
  const std::vector<std::size_t> sensors = sensors_of(noisy.rows(), angles);
  std::vector<std::array<bool, kOutageKinds.size()>> out(sensors.empty() ? 0 : sensors.back() + 1);
  for (Eigen::Index k = 1; k < noisy.cols(); ++k) {
    for (std::size_t sensor = 0; sensor < out.size(); ++sensor)
      for (std::size_t i = 0; i < kOutageKinds.size(); ++i) {
        const OutageRate& rate = config_.of(sensor).outages[i];
        if (rate.share == 0.0) continue;
        const OutageOdds odds = outage_odds(rate);
        out[sensor][i] = trainer::uniform01(timing_) < (out[sensor][i] ? odds.goes_on : odds.begins);
      }
    for (Eigen::Index row = 0; row < noisy.rows(); ++row) {
      const std::size_t sensor = sensors[static_cast<std::size_t>(row)];
      const auto is_out = [&](OutageKind kind) { return out[sensor][static_cast<std::size_t>(kind)]; };
      const bool cosine = row > 0 && sensors[static_cast<std::size_t>(row) - 1] == sensor;
      if (is_out(OutageKind::kStuck)) noisy(row, k) = noisy(row, k - 1);
      if (is_out(OutageKind::kDead)) noisy(row, k) = cosine ? 1.0 : 0.0;
      if (is_out(OutageKind::kMissing)) noisy(row, k) = std::numeric_limits<double>::quiet_NaN();
    }
  }
}

Eigen::MatrixXd held(Eigen::MatrixXd outputs) {
  for (Eigen::Index k = 1; k < outputs.cols(); ++k)
    for (Eigen::Index row = 0; row < outputs.rows(); ++row)
      if (std::isnan(outputs(row, k))) outputs(row, k) = outputs(row, k - 1);
  return outputs;
}

Dataset held(Dataset runs) {
  for (Trajectory& run : runs.trajectories) run.outputs = held(std::move(run.outputs));
  runs.compute_outputs();
  return runs;
}

Dataset with_noise(Dataset runs, const NoiseConfig& noise, std::uint64_t seed) {
  const Eigen::Index measured = codegen::measured_outputs(runs.outputs);
  for (std::size_t i = 0; i < runs.trajectories.size(); ++i) {
    auto y = runs.trajectories[i].outputs.topRows(measured);
    y = MeasurementNoise(noise, seed, i).on(y, runs.output_angles);
  }
  runs.compute_outputs();
  return runs;
}

NoiseConfig without_shifts(NoiseConfig noise) {
  for (SensorNoise& sensor : noise.sensors) sensor.delay_low = sensor.delay_high = sensor.jitter = 0.0;
  return noise;
}

double noise_variance(const SensorNoise& noise) {
  return noise.scale * noise.scale * noise_row(noise.kind).variance;
}

Eigen::VectorXd noise_variances(const NoiseConfig& noise) {
  Eigen::VectorXd variances(static_cast<Eigen::Index>(noise.sensors.size()));
  for (std::size_t i = 0; i < noise.sensors.size(); ++i)
    variances(static_cast<Eigen::Index>(i)) = noise_variance(noise.sensors[i]);
  return variances;
}

std::string sensor_title(const SensorNoise& noise) {
  std::string title = noise_row(noise.kind).title(noise);
  if (noise.outlier_share > 0.0)
    title +=
        " + " + shortest_text(100.0 * noise.outlier_share) + " % outliers to " + shortest_text(noise.outlier_amplitude);
  if (noise.bias > 0.0) title += " + bias to " + shortest_text(noise.bias);
  if (noise.common_bias > 0.0) title += " + common bias to " + shortest_text(noise.common_bias);
  if (noise.limit > 0.0) title += " clipped at " + shortest_text(noise.limit);
  if (noise.quantum > 0.0) title += " in steps of " + shortest_text(noise.quantum);
  if (noise.delayed())
    title += ", " + shortest_text(noise.delay_low) +
             (noise.delay_low < noise.delay_high ? " to " + shortest_text(noise.delay_high) : "") + " samples late";
  if (noise.jitter > 0.0) title += ", jitter of " + shortest_text(100.0 * noise.jitter) + " % of the period";
  for (const OutageKind kind : kOutageKinds) {
    const auto& [share, samples] = noise.outage(kind);
    if (share > 0.0) title += fmt::format(", {} % {}", shortest_text(100.0 * share), outage_word(kind));
    if (share > 0.0 && samples > 0.0) title += " in bursts of " + shortest_text(samples);
  }
  return title;
}

std::string noise_title(const NoiseConfig& noise) {
  if (noise.none()) return "no noise";
  std::string title;
  for (const SensorNoise& sensor : noise.sensors) title += (title.empty() ? "" : ", ") + sensor_title(sensor);
  return title;
}

}  // namespace nlo::trainer
