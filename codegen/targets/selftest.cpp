// SPDX-License-Identifier: MIT
#include "codegen/targets/selftest.h"

#include <map>
#include <string>

#include "codegen/base/embedded_text.h"
#include "codegen/export/number_formats.h"
#include "codegen/targets/c99.h"
#include "codegen/targets/replay.h"

namespace nlo::codegen {

std::vector<NamedText> selftest(const PreparedExport& given) {
  const PreparedExport prepared = for_c99(given, "selftest");
  const Model& m = prepared.model();
  const std::string& name = prepared.name();
  const bool single = prepared.initialiser().scalar_bytes() == 4;
  std::string flags = number_flags(prepared.options());
  if (name != m.name) flags += " --name " + name;
  const std::map<std::string, std::string> values = {
      {"NAME", name},
      {"FLAGS", flags},
      {"SCALAR", prepared.initialiser().scalar_name()},
      {"BITS", single ? "uint32_t" : "uint64_t"},
      {"NX", std::to_string(m.nx())},
      {"NZ", std::to_string(m.nz())},
      {"SAMPLES", std::to_string(prepared.options().samples)},
      {"U_ARGUMENT", m.nu() > 0 ? ", sample->u" : ""},
  };
  std::vector<NamedText> files = c99(prepared);
  files.push_back({name + "_replay.h", replay_c99(prepared)});
  for (const char* file : {"NAME_selftest.h", "NAME_selftest.c", "nlo_cycles.h", "main.c", "README.md"}) {
    std::string path = file;
    if (path.starts_with("NAME")) path.replace(0, 4, name);
    files.push_back({path, filled(embedded_text("selftest/" + std::string(file) + ".in"), values)});
  }
  return files;
}

}  // namespace nlo::codegen
