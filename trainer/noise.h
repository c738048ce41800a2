// SPDX-License-Identifier: MIT
// Measurement noise as it is named on the command line and in configs: "none", "gaussian:0.5", "uniform:3".
#pragma once

#include <string>
#include <string_view>

namespace nlo::trainer {

enum class NoiseKind { kNone, kGaussian, kUniform };

struct NoiseConfig {
  NoiseKind kind = NoiseKind::kNone;
  double scale = 0.0;  ///< Gaussian: standard deviation; uniform: half width. In the outputs' units.

  bool operator==(const NoiseConfig&) const = default;
};

/// Throws codegen::Error naming what is wrong and the three forms. A scale must be finite and not negative.
NoiseConfig parse_noise(std::string_view text);

/// The text that parse_noise reads back to the same value.
std::string format_noise(const NoiseConfig& noise);

}  // namespace nlo::trainer
