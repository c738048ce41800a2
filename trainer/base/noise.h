// SPDX-License-Identifier: MIT
// Measurement noise as it is named on the command line and in configs: "none", "gaussian:0.5", "uniform:3",
// "student:0.5:2"; of several outputs one for all of them, or a list with one for each: "gaussian:0.1,uniform:0.02".
// Further properties of a sensor follow it: "gaussian:0.5+outliers:0.05:10+bias:0.2+quantised:0.1". So does its
// timing: "none+delay:1.5+jitter:0.2+missing:0.05:4". And so do faults: "none+stuck:0.02:50+dead:0.02:50+clipped:2".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace nlo::trainer {

/// Its row in noise_table.h says all about it.
enum class NoiseKind { kNone, kGaussian, kUniform, kStudent };

/// The output of a sensor during an outage: nothing, which the observer is told; its last value; or zero. The last two
/// look like measurements.
enum class OutageKind : std::uint8_t { kMissing, kStuck, kDead };
inline constexpr std::array kOutageKinds = {OutageKind::kMissing, OutageKind::kStuck, OutageKind::kDead};

/// "missing", "stuck" or "dead".
std::string_view outage_word(OutageKind kind);

struct OutageRate {
  double share = 0.0;    ///< share of the samples
  double samples = 0.0;  ///< mean length in a row; 0: each sample by itself

  bool operator==(const OutageRate&) const = default;
};

/// The noise of one sensor.
struct SensorNoise {
  NoiseKind kind = NoiseKind::kNone;
  /// Gaussian: standard deviation; uniform: half width; Student's t: its unit. In the output's unit.
  double scale = 0.0;
  int shape = 0;  ///< Student's t: degrees of freedom, 1 to 30; few are heavy tails
  double outlier_share = 0.0,
         outlier_amplitude = 0.0;  ///< this share of the samples is off by U(-amplitude, amplitude) more
  double bias = 0.0;               ///< U(-bias, bias), drawn once for each run
  double common_bias = 0.0;        ///< times one U(-1, 1) of each run that all sensors share: a supply or a mounting
  double limit = 0.0;              ///< measurements end at +-limit; 0: no limit
  double quantum = 0.0;            ///< measurements are multiples of it; 0: not quantised

  double delay_low = 0.0,
         delay_high = 0.0;  ///< it shows y of so many samples ago, a number drawn from this range for each run
  double jitter = 0.0;      ///< its instants are off by U(-jitter, jitter) sample periods, each by its own draw
  std::array<OutageRate, kOutageKinds.size()> outages = {};

  OutageRate& outage(OutageKind which) { return outages[static_cast<std::size_t>(which)]; }
  const OutageRate& outage(OutageKind which) const { return outages[static_cast<std::size_t>(which)]; }
  bool fails() const { return outages != decltype(outages){}; }
  /// Its output during an outage looks like a measurement.
  bool lies() const;

  bool delayed() const { return delay_high > 0.0; }
  /// It measures at other times than the observer is told.
  bool shifted() const { return delayed() || jitter > 0.0; }
  /// Some measurements are far off, without a limit.
  bool has_tails() const;
  /// Whether the noise changes a measurement.
  bool disturbed() const {
    return kind != NoiseKind::kNone || outlier_share > 0.0 || biased() || limit > 0.0 || quantum > 0.0;
  }
  bool biased() const { return bias > 0.0 || common_bias > 0.0; }
  /// Nothing at all is done to it.
  bool none() const { return !disturbed() && !shifted() && !fails(); }

  bool operator==(const SensorNoise&) const = default;
};

/// The noise of all sensors of a plant or a rig. An output that is given as its sine and cosine has one sensor, and the
/// noise is on the angle, as for an encoder.
struct NoiseConfig {
  std::vector<SensorNoise> sensors = {SensorNoise{}};  ///< one for all outputs, or one for each, in their order

  NoiseConfig() = default;
  NoiseConfig(NoiseKind kind, double scale) : sensors{{kind, scale}} {}

  const SensorNoise& of(std::size_t output) const { return sensors.size() == 1 ? sensors.front() : sensors.at(output); }
  bool none() const;     ///< no sensor has any
  bool shifted() const;  ///< one sensor measures at other times
  bool fails() const;    ///< one sensor is out now and then

  bool operator==(const NoiseConfig&) const = default;
};

/// Noises that trajectories meet in turn, eight of them the same one. Each noise is equally frequent at every step.
struct NoiseMixture {
  std::vector<NoiseConfig> parts;  ///< at least one

  NoiseMixture() : parts(1) {}
  explicit(false) NoiseMixture(NoiseConfig one) : parts{std::move(one)} {}
  explicit NoiseMixture(std::vector<NoiseConfig> several) : parts(std::move(several)) {}

  const NoiseConfig& of(std::uint64_t group) const { return parts[group % parts.size()]; }
};

/// One noise, or several with commas between them. Throws codegen::Error with the reason and the possible forms.
/// A scale must be finite and not negative.
NoiseConfig parse_noise(std::string_view text);

/// The text that parse_noise reads back to the same value.
std::string format_noise(const SensorNoise& noise);
std::string format_noise(const NoiseConfig& noise);

/// Probabilities that an outage continues and that it begins at a sample. Outages have the declared mean length and
/// add up to the declared share. The first sample of a run always arrives.
struct OutageOdds {
  double goes_on = 0.0, begins = 0.0;
};
OutageOdds outage_odds(const OutageRate& rate);

/// Throws codegen::Error unless it is one for all of `outputs` sensors, or one for each.
void check_noise(const NoiseConfig& noise, std::size_t outputs);

}  // namespace nlo::trainer
