// SPDX-License-Identifier: MIT
#include "codegen/targets/generated.h"

#include "codegen/readback/read_back.h"

namespace nlo::codegen {

std::vector<NamedText> generated(const ExportTarget& target, const PreparedExport& prepared) {
  std::vector<NamedText> files = target.generate(prepared);
  if (target.name == "cpp") check_text(prepared, TextForm::kCpp, files);
  if (target.name == "single") check_text(prepared, TextForm::kSingle, files);
  if (target.name == "c99") check_text(prepared, TextForm::kC99, files);
  return files;
}

}  // namespace nlo::codegen
