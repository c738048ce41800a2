// SPDX-License-Identifier: MIT
#include "codegen/targets/selftest.h"

#include <map>
#include <string>

#include "codegen/targets/c99.h"
#include "codegen/targets/export_parts.h"
#include "codegen/targets/golden_replay.h"

namespace nlo::codegen {

std::vector<NamedText> selftest(const PreparedExport& given) {
  const PreparedExport prepared = for_c99(given, "selftest");
  const std::string& name = prepared.name();
  std::map<std::string, std::string> values = wrapper_values(prepared);
  values["BITS"] = prepared.initialiser().scalar_bytes() == 4 ? "uint32_t" : "uint64_t";
  values["SAMPLES"] = std::to_string(prepared.options().samples);
  values["U_ARGUMENT"] = prepared.model().nu() > 0 ? ", sample->u" : "";
  std::vector<NamedText> files = c99(prepared);
  files.push_back({name + "_replay.h", replay_c99(prepared)});
  for (NamedText& file : filled_folder("selftest/", name, values)) files.push_back(std::move(file));
  return files;
}

}  // namespace nlo::codegen
