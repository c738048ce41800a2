// SPDX-License-Identifier: MIT
#include "trainer/noise.h"

#include <fmt/format.h>

#include "codegen/error.h"
#include "trainer/number_text.h"

namespace nlo::trainer {

NoiseConfig parse_noise(std::string_view text) {
  if (text == "none") return {};
  const auto colon = text.find(':');
  const std::string_view kind = text.substr(0, colon);
  const auto fail = [&](std::string_view what) {
    throw codegen::Error(
        fmt::format("noise \"{}\" {}; write none, gaussian:STANDARD_DEVIATION or uniform:HALF_WIDTH", text, what));
  };
  if (kind != "gaussian" && kind != "uniform") fail("is of no known kind");
  if (colon == std::string_view::npos) fail("has no scale");
  const auto scale = finite_number(text.substr(colon + 1));
  if (!scale) fail("has a scale that is no number");
  if (*scale < 0.0) fail("has a negative scale");
  return {kind == "gaussian" ? NoiseKind::kGaussian : NoiseKind::kUniform, *scale};
}

std::string format_noise(const NoiseConfig& noise) {
  switch (noise.kind) {
    case NoiseKind::kGaussian:
      return "gaussian:" + shortest_text(noise.scale);
    case NoiseKind::kUniform:
      return "uniform:" + shortest_text(noise.scale);
    case NoiseKind::kNone:
      break;
  }
  return "none";
}

}  // namespace nlo::trainer
