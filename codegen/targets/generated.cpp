// SPDX-License-Identifier: MIT
#include "codegen/targets/generated.h"

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>

#include "codegen/base/fail.h"
#include "codegen/base/zip.h"
#include "codegen/readback/read_back.h"

namespace nlo::codegen {
namespace {

/// A file name without folder and ending, which its text calls itself too: "rig_c99".
std::string stem_of(const std::string& path) {
  const std::size_t name = path.rfind('/') + 1;
  return path.substr(name, path.rfind('.') - name);
}

std::optional<TextForm> form_of(const NamedText& file) {
  const std::string stem = stem_of(file.path);
  const auto says = [&](const std::string& text) { return file.text.find("\n" + text) != std::string::npos; };
  if (says("#define " + stem + "_EXPORT ")) return TextForm::kC99;
  if (says("namespace nlo::single::" + stem + " {")) return TextForm::kSingle;
  if (says("inline constexpr Model kModel = {")) return TextForm::kCpp;
  return std::nullopt;
}

/// Reads each observer among `files` back. How many there are.
int read_back(const PreparedExport& prepared, const std::vector<NamedText>& files) {
  int observers = 0;
  for (const NamedText& file : files) {
    const std::optional<TextForm> form = form_of(file);
    if (!form) continue;
    ++observers;
    std::vector<NamedText> texts = {file};
    const std::string stem = stem_of(file.path);
    if (form == TextForm::kC99)
      std::copy_if(files.begin(), files.end(), std::back_inserter(texts),
                   [&](const NamedText& other) { return other.path.ends_with(".c") && stem_of(other.path) == stem; });
    if (stem == prepared.name()) {
      check_text(prepared, *form, texts);
      continue;
    }
    ExportOptions renamed = prepared.options();
    renamed.name = stem;
    check_text(prepared.with(renamed), *form, texts);
  }
  return observers;
}

}  // namespace

std::vector<NamedText> generated(const ExportTarget& target, const PreparedExport& prepared) {
  std::vector<NamedText> files = target.generate(prepared);
  if (target.no_observer) return files;
  const bool archive = files.size() == 1 && files.front().text.starts_with("PK");
  if (read_back(prepared, archive ? unzipped(files.front().text) : files) == 0)
    fail("target {}: there is no observer in its files; nothing is written: this is a fault of nlo, please report it",
         target.name);
  return files;
}

}  // namespace nlo::codegen
