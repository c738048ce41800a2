// SPDX-License-Identifier: MIT
#include "codegen/targets/export_parts.h"

#include <fmt/format.h>

#include "codegen/error.h"
#include "codegen/targets/generated_text.h"

namespace nlo::codegen {

std::string channel_text(const Channel& channel) {
  return channel.name + (channel.unit.empty() ? "" : " [" + safe_comment(channel.unit, 20) + "]");
}

std::string channel_list(const std::vector<Channel>& channels, bool with_units) {
  std::string text;
  for (const Channel& channel : channels) {
    if (!text.empty()) text += ", ";
    text += with_units ? channel_text(channel) : channel.name;
  }
  return text;
}

std::string with_activations(Eigen::Index multiply_adds, Eigen::Index activations) {
  return grouped(multiply_adds) + " multiply-adds" +
         (activations == 0 ? "" : ", " + grouped(activations) + " activations");
}

std::string facts(const Model& m) {
  constexpr std::size_t kLongestName = 28, kLongestFact = 84;
  std::string text;
  for (const auto& [name, fact] : m.provenance) {
    if (fact.find_first_of("\r\n") != std::string::npos) continue;  // a whole config: the model file has it
    text += fmt::format("//   {:<{}}  {}\n", safe_comment(name, kLongestName), kLongestName,
                        safe_comment(fact, kLongestFact));
  }
  return text.empty() ? "" : "// About the model\n" + text + "//\n";
}

void check_rounding(const Model& m, ScalarType scalar) {
  if (scalar == ScalarType::kDouble) return;
  const auto rounded = [](double value) { return static_cast<float>(value); };
  if (!(rounded(m.sample_period_s) > 0.0F))
    throw Error("sample_period_s rounds to zero in float; export with scalar double");
  for (int j = 0; j < m.ny(); ++j)
    if (!(rounded(m.output_min(j)) < rounded(m.output_max(j))))
      throw Error(fmt::format("output_min[{0}] and output_max[{0}] are equal in float; export with scalar double", j));
}

}  // namespace nlo::codegen
