// SPDX-License-Identifier: MIT
#include "trainer/analysis/measurement_noise.h"

#include <cmath>

#include "trainer/number_text.h"

namespace nlo::trainer {
namespace {

/// SplitMix64 (Steele, Lea, Flood 2014): a bijection that scatters neighbouring seeds.
constexpr std::uint64_t split_mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

}  // namespace

MeasurementNoise::MeasurementNoise(const NoiseConfig& config, std::uint64_t seed, std::uint64_t run)
    : config_(config), engine_(split_mix(split_mix(seed) + run)) {}

double MeasurementNoise::uniform01() {
  return static_cast<double>(engine_() >> 11) * 0x1p-53;
}

double MeasurementNoise::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_normal_;
  }
  double v1, v2, q;
  do {
    v1 = 2.0 * uniform01() - 1.0;
    v2 = 2.0 * uniform01() - 1.0;
    q = v1 * v1 + v2 * v2;
  } while (q >= 1.0 || q == 0.0);
  const double factor = std::sqrt(-2.0 * std::log(q) / q);
  spare_normal_ = v2 * factor;
  has_spare_ = true;
  return v1 * factor;
}

double MeasurementNoise::draw() {
  switch (config_.kind) {
    case NoiseKind::kNone:
      return 0.0;
    case NoiseKind::kGaussian:
      return config_.scale * normal();
    case NoiseKind::kUniform:
      return config_.scale * (2.0 * uniform01() - 1.0);
  }
  return 0.0;
}

Eigen::MatrixXd MeasurementNoise::on(const Eigen::MatrixXd& outputs) {
  Eigen::MatrixXd noisy = outputs;
  for (double& y : noisy.reshaped()) y += draw();
  return noisy;
}

double noise_variance(const NoiseConfig& noise) {
  switch (noise.kind) {
    case NoiseKind::kNone:
      return 0.0;
    case NoiseKind::kGaussian:
      return noise.scale * noise.scale;
    case NoiseKind::kUniform:
      return noise.scale * noise.scale / 3.0;
  }
  return 0.0;
}

std::string noise_title(const NoiseConfig& noise) {
  switch (noise.kind) {
    case NoiseKind::kNone:
      return "no noise";
    case NoiseKind::kGaussian:
      return "N(0, " + shortest_text(noise.scale) + ")";
    case NoiseKind::kUniform:
      return "U(-" + shortest_text(noise.scale) + ", " + shortest_text(noise.scale) + ")";
  }
  return "no noise";
}

}  // namespace nlo::trainer
