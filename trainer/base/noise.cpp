// SPDX-License-Identifier: MIT
#include "trainer/base/noise.h"

#include <fmt/format.h>

#include <algorithm>

#include "codegen/base/error.h"
#include "trainer/base/number_text.h"

namespace nlo::trainer {
namespace {

SensorNoise parse_sensor(std::string_view text) {
  const auto colon = text.find(':');
  const std::optional<NoiseKind> kind = from_name<NoiseKind>(text.substr(0, colon));
  const bool has_scale = colon != std::string_view::npos;
  if (kind == NoiseKind::kNone && !has_scale) return {};
  const auto fail = [&](std::string_view what) {
    throw codegen::Error(
        fmt::format("noise \"{}\" {}; write none, gaussian:STANDARD_DEVIATION or uniform:HALF_WIDTH", text, what));
  };
  if (!kind || kind == NoiseKind::kNone) fail("is of no known kind");
  if (!has_scale) fail("has no scale");
  const auto scale = finite_number(text.substr(colon + 1));
  if (!scale) fail("has a scale that is no number");
  if (*scale < 0.0) fail("has a negative scale");
  return {*kind, *scale};
}

}  // namespace

bool NoiseConfig::none() const {
  return std::all_of(sensors.begin(), sensors.end(), [](const auto& noise) { return noise.kind == NoiseKind::kNone; });
}

NoiseConfig parse_noise(std::string_view text) {
  NoiseConfig noise;
  noise.sensors.clear();
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find(',', start), text.size());
    noise.sensors.push_back(parse_sensor(text.substr(start, end - start)));
    start = end + 1;
  }
  return noise;
}

std::string format_noise(const SensorNoise& noise) {
  const std::string kind(to_name(noise.kind));
  return noise.kind == NoiseKind::kNone ? kind : kind + ":" + shortest_text(noise.scale);
}

std::string format_noise(const NoiseConfig& noise) {
  std::string text;
  for (const SensorNoise& sensor : noise.sensors) text += (text.empty() ? "" : ",") + format_noise(sensor);
  return text;
}

void check_noise(const NoiseConfig& noise, std::size_t outputs) {
  if (noise.sensors.size() == 1 || noise.sensors.size() == outputs) return;
  throw codegen::Error(
      fmt::format("noise \"{}\" is of {} outputs, but there {} {}; give one for all of them, or one for "
                  "each (\"none\" where there is none)",
                  format_noise(noise), noise.sensors.size(), outputs == 1 ? "is" : "are", outputs));
}

}  // namespace nlo::trainer
