// SPDX-License-Identifier: MIT
#include "codegen/targets/observers_in.h"

#include <algorithm>
#include <optional>
#include <string>

#include "codegen/base/zip.h"

namespace nlo::codegen {
namespace {

/// Returns a file name without folder and ending, "rig_c99". The text of the file uses the same name.
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

/// Returns the files of the archive, or `files` if they are not an archive.
std::vector<NamedText> unpacked(const std::vector<NamedText>& files) {
  return files.size() == 1 && files.front().text.starts_with("PK") ? unzipped(files.front().text) : files;
}

}  // namespace

std::vector<GeneratedObserver> observers_in(const std::vector<NamedText>& given) {
  const std::vector<NamedText> files = unpacked(given);
  std::vector<GeneratedObserver> observers;
  for (const NamedText& file : files) {
    const std::optional<TextForm> form = form_of(file);
    if (!form) continue;
    GeneratedObserver observer{*form, stem_of(file.path), {file}};
    if (form == TextForm::kC99)
      std::copy_if(files.begin(), files.end(), std::back_inserter(observer.files), [&](const NamedText& other) {
        return other.path.ends_with(".c") && stem_of(other.path) == observer.name;
      });
    observers.push_back(std::move(observer));
  }
  return observers;
}

PreparedExport named(const PreparedExport& prepared, const std::string& name) {
  ExportOptions options = prepared.options();
  if (name != prepared.name()) options.name = name;
  return prepared.with(options);
}

}  // namespace nlo::codegen
