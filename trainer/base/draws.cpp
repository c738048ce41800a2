// SPDX-License-Identifier: MIT
#include "trainer/base/draws.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

namespace nlo::trainer {

double rounded(double value) {
  const std::string text = fmt::format("{:.2e}", value);
  double result = value;  // a value that is not finite is kept
  std::from_chars(text.data(), text.data() + text.size(), result);
  return result;
}

void vary_widths(std::vector<int>& hidden, Draws& draws) {
  constexpr int kVector = 8;  // floats that a kernel processes together
  constexpr std::size_t kMostLayers = 4;
  const double wider = draws.one_of({0.5, 0.75, 1.0, 1.0, 1.5, 2.0});
  for (int& width : hidden)
    width = std::clamp(static_cast<int>(std::lround(width * wider / kVector)) * kVector, kVector, 1024);
  switch (draws.below(5)) {
    case 0:
      if (hidden.size() > 1) hidden.pop_back();
      break;
    case 1:
      if (!hidden.empty() && hidden.size() < kMostLayers) hidden.push_back(hidden.back());
      break;
    default:
      break;
  }
}

}  // namespace nlo::trainer
