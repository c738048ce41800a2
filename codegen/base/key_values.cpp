// SPDX-License-Identifier: MIT
#include "codegen/base/key_values.h"

#include <algorithm>
#include <charconv>
#include <limits>

#include "codegen/base/fail.h"

namespace nlo::codegen {

std::vector<std::pair<std::string, std::string>> key_values(std::string_view text, const std::string& option) {
  std::vector<std::pair<std::string, std::string>> pairs;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find(',', start), text.size());
    const std::string_view part = text.substr(start, end - start);
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos || equals == 0 || equals + 1 == part.size())
      fail("{}: \"{}\" is not KEY=VALUE; separate several by commas", option, part);
    const std::string key(part.substr(0, equals));
    for (const auto& [known, unused] : pairs)
      if (known == key) fail("{}: \"{}\" is given twice; remove one", option, key);
    pairs.emplace_back(key, part.substr(equals + 1));
    start = end + 1;
  }
  return pairs;
}

double decimal(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::numeric_limits<double>::quiet_NaN();
  return value;
}

}  // namespace nlo::codegen
