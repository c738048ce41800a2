// SPDX-License-Identifier: MIT
#include "trainer/app/commands/output_directory.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <system_error>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/app/commands/command.h"

namespace nlo::trainer {
namespace {

namespace fs = std::filesystem;

/// Returns the directory itself, or the nearest existing one above it, in which it would be made.
fs::path nearest_existing(fs::path path) {
  std::error_code ignored;
  path = fs::absolute(path, ignored);
  while (path.has_relative_path() && !fs::exists(fs::symlink_status(path, ignored))) path = path.parent_path();
  return path;
}

bool writable(const fs::path& path) {
  return ::access(path.c_str(), W_OK | X_OK) == 0;
}

}  // namespace

void check_output_directory(const std::string& path) {
  if (is_stdout(path))
    throw codegen::Error(
        "-o -: this command writes a folder of files, but stdout is a single file; name a folder: -o DIR (./- for one "
        "of that "
        "name)");
  const fs::path existing = nearest_existing(path);
  std::error_code ignored;
  if (!fs::is_directory(existing, ignored))
    throw codegen::Error(
        fmt::format("{}: {} is a file; choose another directory with -o DIR", path, existing.string()));
  if (!writable(existing))
    throw codegen::Error(
        fmt::format("{}: no permission to write in {}; choose another directory with -o DIR", path, existing.string()));
}

void make_output_directory(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error)
    throw codegen::Error(
        fmt::format("{}: cannot make the directory: {}; choose another with -o DIR", path, error.message()));
}

OutputDirectory::OutputDirectory(const std::string& path) {
  check_output_directory(path);
  const fs::path existing = nearest_existing(path);
  for (fs::path missing = fs::absolute(path); missing != existing; missing = missing.parent_path())
    made_.push_back(missing.string());
  run_phase([&] { make_output_directory(path); });
  lock_.take(path);
}

OutputDirectory::~OutputDirectory() {
  std::error_code is_in_use;
  for (const std::string& directory : made_) fs::remove(directory, is_in_use);
}

bool is_stdout(const std::string& output) {
  return output == "-";
}

void make_folder_of(const std::string& file) {
  if (const fs::path parent = fs::path(file).parent_path(); !parent.empty()) make_output_directory(parent.string());
}

void check_output_file(const std::string& file, bool makes_folder) {
  if (is_stdout(file)) return;
  std::error_code ignored;
  if (file.empty()) throw codegen::Error("-o: the file name is empty; write -o FILE");
  if (fs::is_directory(file, ignored))
    throw codegen::Error(fmt::format("{}: is a directory; write -o {}/FILE", file, file));
  fs::path parent = fs::path(file).parent_path();
  if (parent.empty()) parent = ".";
  if (makes_folder) parent = nearest_existing(parent);
  if (makes_folder && !fs::is_directory(parent, ignored))
    throw codegen::Error(fmt::format("{}: {} is a file, not a folder; write to another folder", file, parent.string()));
  if (!fs::is_directory(parent, ignored))
    throw codegen::Error(fmt::format("{}: there is no directory {}; create it first", file, parent.string()));
  if (!writable(parent) && ::access(file.c_str(), W_OK) != 0)
    throw codegen::Error(fmt::format("{}: no permission to write in {}", file, parent.string()));
}

void write_output_file(const std::string& file, const std::string& text) {
  if (is_stdout(file)) {
    std::fwrite(text.data(), 1, text.size(), stdout);  // main() checks for errors
  } else {
    codegen::write_file_atomically(file, text);
  }
}

}  // namespace nlo::trainer
