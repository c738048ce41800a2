// SPDX-License-Identifier: MIT
// Measurement noise in the form of the command line and of experiments: "none", "gaussian:0.5", "uniform:3",
// "student:0.5:2". For several outputs it is one noise for all, or a list with one for each:
// "gaussian:0.1,uniform:0.02". Further properties of a sensor follow it:
// "gaussian:0.5+outliers:0.05:10+bias:0.2+quantised:0.1". Timing follows in the same way:
// "none+delay:1.5+jitter:0.2+missing:0.05:4". So do faults: "none+stuck:0.02:50+dead:0.02:50+clipped:2".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace nlo::trainer {

/// Kind of a noise. noise_table.h has a row for each with its properties.
enum class NoiseKind { kNone, kGaussian, kUniform, kStudent };

/// Output of a sensor during an outage: nothing (the observer knows that it is missing), its last value, or zero. The
/// last two look like measurements.
enum class OutageKind : std::uint8_t { kMissing, kStuck, kDead };
inline constexpr std::array kOutageKinds = {OutageKind::kMissing, OutageKind::kStuck, OutageKind::kDead};

/// Returns "missing", "stuck" or "dead".
std::string_view outage_word(OutageKind kind);

struct OutageRate {
  double share = 0.0;    ///< share of the samples
  double samples = 0.0;  ///< mean length of an outage [samples]; 0: independent samples

  bool operator==(const OutageRate&) const = default;
};

/// The noise of one sensor.
struct SensorNoise {
  NoiseKind kind = NoiseKind::kNone;
  /// Gaussian: standard deviation. Uniform: half width. Student's t: scale. In the output's unit.
  double scale = 0.0;
  int shape = 0;  ///< Student's t: degrees of freedom, 1 to 30; few of them give heavy tails
  double outlier_share = 0.0,
         outlier_amplitude = 0.0;  ///< U(-amplitude, amplitude) is added to this share of the samples
  double bias = 0.0;               ///< U(-bias, bias), drawn once for each run
  double common_bias = 0.0;        ///< factor of a U(-1, 1) that all sensors of a run share: a supply or a mounting
  double limit = 0.0;              ///< measurements are clipped to +-limit; 0: no limit
  double quantum = 0.0;            ///< measurements are multiples of it; 0: not quantised

  double delay_low = 0.0,
         delay_high = 0.0;  ///< the sensor shows y of this many samples ago, drawn from this range for each run
  double jitter = 0.0;      ///< U(-jitter, jitter) sample periods are added to each sampling instant
  std::array<OutageRate, kOutageKinds.size()> outages = {};

  OutageRate& outage(OutageKind which) { return outages[static_cast<std::size_t>(which)]; }
  const OutageRate& outage(OutageKind which) const { return outages[static_cast<std::size_t>(which)]; }
  bool fails() const { return outages != decltype(outages){}; }
  /// Returns true if its output during an outage looks like a measurement.
  bool lies() const;

  bool delayed() const { return delay_high > 0.0; }
  /// Returns true if it measures at other times than the observer assumes.
  bool shifted() const { return delayed() || jitter > 0.0; }
  /// Returns true if the error of a measurement has no limit.
  bool has_tails() const;
  /// Returns true if the noise changes a measurement.
  bool disturbed() const {
    return kind != NoiseKind::kNone || outlier_share > 0.0 || biased() || limit > 0.0 || quantum > 0.0;
  }
  bool biased() const { return bias > 0.0 || common_bias > 0.0; }
  /// Returns true if the measurements are exact, on time and complete.
  bool none() const { return !disturbed() && !shifted() && !fails(); }

  bool operator==(const SensorNoise&) const = default;
};

/// The noise of all sensors of a plant or a rig. An output that is given as sine and cosine has one sensor, and the
/// noise is added to the angle, as for an encoder.
struct NoiseConfig {
  std::vector<SensorNoise> sensors = {SensorNoise{}};  ///< one for all outputs, or one for each in their order

  NoiseConfig() = default;
  NoiseConfig(NoiseKind kind, double scale) : sensors{{kind, scale}} {}

  const SensorNoise& of(std::size_t output) const { return sensors.size() == 1 ? sensors.front() : sensors.at(output); }
  bool none() const;     ///< true if no sensor has noise
  bool shifted() const;  ///< true if a sensor measures at other times
  bool fails() const;    ///< true if a sensor has outages

  bool operator==(const NoiseConfig&) const = default;
};

/// Noises that alternate between groups of eight trajectories. Each noise is equally frequent at every step.
struct NoiseMixture {
  std::vector<NoiseConfig> parts;  ///< at least one

  NoiseMixture() : parts(1) {}
  explicit(false) NoiseMixture(NoiseConfig one) : parts{std::move(one)} {}
  explicit NoiseMixture(std::vector<NoiseConfig> several) : parts(std::move(several)) {}

  const NoiseConfig& of(std::uint64_t group) const { return parts[group % parts.size()]; }
};

/// Reads one noise, or several with commas between them. Throws codegen::Error with the reason and the possible forms.
/// A scale must be finite and not negative.
NoiseConfig parse_noise(std::string_view text);

/// Returns the text that parse_noise() reads back to the same value.
std::string format_noise(const SensorNoise& noise);
std::string format_noise(const NoiseConfig& noise);

/// Probabilities that an outage begins and that it continues at a sample. Outages have the declared mean length and the
/// declared share of all samples. The first sample of a run always arrives.
struct OutageOdds {
  double goes_on = 0.0, begins = 0.0;
};
OutageOdds outage_odds(const OutageRate& rate);

/// Throws codegen::Error unless there is one noise for all of `outputs` sensors, or one for each.
void check_noise(const NoiseConfig& noise, std::size_t outputs);

}  // namespace nlo::trainer
