// SPDX-License-Identifier: MIT
#include "trainer/app/commands/option_facts.h"

#include <fmt/format.h>

#include <algorithm>

namespace nlo::trainer {
namespace {

/// Returns the words of "TEXT:{ekf,constant}", CLI11's type name of an option with fixed values.
std::vector<std::string> members_in(const std::string& type) {
  const auto open = type.find('{'), close = type.rfind('}');
  std::vector<std::string> members;
  if (open == std::string::npos || close == std::string::npos) return members;
  for (std::size_t start = open + 1; start < close;) {
    const std::size_t end = std::min(type.find(',', start), close);
    members.push_back(type.substr(start, end - start));
    start = end + 1;
  }
  return members;
}

/// Returns "1 to 100" for "INT in [1 - 100]", CLI11's type name of a number in a range.
std::string range_in(const std::string& type) {
  const auto open = type.find(" in ["), middle = type.find(" - ", open), close = type.find(']', open);
  if (open == std::string::npos || middle == std::string::npos || close == std::string::npos || middle > close)
    return "";
  return fmt::format("{} to {}", type.substr(open + 5, middle - open - 5), type.substr(middle + 3, close - middle - 3));
}

}  // namespace

OptionFacts facts_of(const CLI::Option& option) {
  OptionFacts facts;
  const std::string type = option.get_type_name();
  if (option.get_items_expected_max() > 0) facts.value = type.substr(0, type.find(':'));
  facts.members = members_in(type);
  facts.range = range_in(type);
  facts.fallback = option.get_default_str();
  facts.required = option.get_required();
  facts.repeats = option.get_expected_max() == CLI::detail::expected_max_vector_size;
  facts.description = option.get_description();
  return facts;
}

}  // namespace nlo::trainer
