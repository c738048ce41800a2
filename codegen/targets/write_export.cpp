// SPDX-License-Identifier: MIT
#include "codegen/targets/write_export.h"

#include <fmt/format.h>

#include <filesystem>

#include "codegen/base/directory.h"
#include "codegen/base/error.h"

namespace nlo::codegen {
namespace {

std::vector<NamedText> placed(const std::vector<NamedText>& files, const std::filesystem::path& folder) {
  std::vector<NamedText> result = files;
  for (NamedText& file : result) file.path = (folder / file.path).string();
  return result;
}

}  // namespace

void check_export(const ExportTarget& target, const std::vector<NamedText>& files, const std::string& output) {
  if (target.form == ExportForm::kDirectory) check_directory(output);
  const std::filesystem::path path(output);
  if (target.form == ExportForm::kFiles && path.filename() != files.front().path)
    throw Error(
        fmt::format("{}: target {} writes {} files that include each other, so their name is fixed; write -o {}, or "
                    "change the name with --name",
                    output, target.name, files.size(), (path.parent_path() / files.front().path).string()));
}

std::vector<std::string> write_export(const ExportTarget& target, const std::vector<NamedText>& files,
                                      const std::string& output) {
  const std::filesystem::path path(output);
  if (target.form == ExportForm::kFile) {
    write_file_atomically(output, files.front().text);
    return {output};
  }
  const bool folder = target.form == ExportForm::kDirectory;
  const std::vector<NamedText> written = placed(files, folder ? path : path.parent_path());
  folder ? write_directory_atomically(output, files) : write_files_atomically(written);
  std::vector<std::string> paths;
  for (const NamedText& file : written) paths.push_back(file.path);
  return paths;
}

}  // namespace nlo::codegen
