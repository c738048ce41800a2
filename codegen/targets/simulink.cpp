// SPDX-License-Identifier: MIT
#include "codegen/targets/simulink.h"

#include <fmt/format.h>

#include <map>
#include <string>

#include "codegen/targets/c99.h"
#include "codegen/targets/export_parts.h"

namespace nlo::codegen {

std::vector<NamedText> simulink(const PreparedExport& given) {
  const PreparedExport prepared = for_c99(given, "simulink");
  std::map<std::string, std::string> values = wrapper_values(prepared);
  const std::string inputs_text = channel_list(inputs(prepared.model()), true);
  if (!inputs_text.empty()) {
    values["INPUT_PORT"] = fmt::format("; 2. the known inputs ({})", inputs_text);
    values["INPUT_ROW"] = fmt::format("| input 2 | the known inputs: {} |\n", inputs_text);
  }
  std::vector<NamedText> files = c99(prepared);
  for (NamedText& file : filled_folder("simulink/", prepared.name(), values)) files.push_back(std::move(file));
  return files;
}

}  // namespace nlo::codegen
