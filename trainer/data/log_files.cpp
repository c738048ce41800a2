// SPDX-License-Identifier: MIT
#include "trainer/data/log_files.h"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string_view>

#include "codegen/base/error.h"
#include "codegen/base/file.h"

namespace nlo::trainer {
namespace {

using codegen::Error;
namespace fs = std::filesystem;

class Fnv1a {
 public:
  void add(std::string_view bytes) {
    for (const char c : bytes) add_byte(static_cast<unsigned char>(c));
    for (std::size_t n = bytes.size(), i = 0; i < 8; ++i, n >>= 8) add_byte(static_cast<unsigned char>(n & 0xff));
  }
  std::string hex() const { return fmt::format("{:016x}", state_); }

 private:
  void add_byte(unsigned char byte) { state_ = (state_ ^ byte) * std::uint64_t{0x100000001b3}; }

  std::uint64_t state_ = 0xcbf29ce484222325;
};

/// A directory whose own name holds glob characters is meant literally.
std::string escaped(const std::string& directory) {
  std::string result;
  for (const char c : directory) {
    if (std::string_view("*?[\\").find(c) != std::string_view::npos) result += '\\';
    result += c;
  }
  return result;
}

std::vector<std::string> matches(const std::string& pattern) {
  glob_t found{};
  const int status = ::glob(pattern.c_str(), 0, nullptr, &found);
  std::vector<std::string> paths;
  if (status == 0) paths.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  ::globfree(&found);
  std::erase_if(paths, [](const std::string& path) { return fs::is_directory(path); });
  return paths;
}

}  // namespace

std::vector<std::string> expand_files(const std::string& directory, const std::vector<std::string>& patterns) {
  if (!directory.empty() && !fs::is_directory(directory))
    throw Error(fmt::format("{}: no such directory: expected the logs there (--data DIR)", directory));
  std::vector<std::string> files;
  for (const std::string& pattern : patterns) {
    const bool relative = !directory.empty() && !pattern.starts_with('/');
    // A name that exists is that file, whatever characters it holds.
    const fs::path literal = relative ? fs::path(directory) / pattern : fs::path(pattern);
    std::vector<std::string> found;
    if (fs::is_regular_file(literal)) found.push_back(literal.string());
    if (found.empty()) found = matches(relative ? (fs::path(escaped(directory)) / pattern).string() : pattern);
    if (found.empty())
      throw Error(fmt::format("no file matches \"{}\" in {}: expected a log or a glob such as \"run*.csv\"", pattern,
                              directory.empty() ? "the current directory" : directory));
    files.insert(files.end(), found.begin(), found.end());
  }
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

SplitFiles expand_splits(const LogConfig& config, const std::string& directory) {
  if (config.train_files.empty())
    throw Error("[log]: train_files names no file: expected at least one log to train on");
  SplitFiles splits{expand_files(directory, config.train_files), expand_files(directory, config.validation_files),
                    expand_files(directory, config.test_files)};
  struct Place {
    const char* split;
    std::string file;
  };
  std::map<std::string, Place> seen;  // by content: a copy of a log is the same log
  const auto enter = [&](const char* split, const std::vector<std::string>& files) {
    for (const std::string& file : files) {
      const auto [first, is_new] = seen.try_emplace(content_hash({file}), Place{split, file});
      if (is_new || std::string_view(first->second.split) == split) continue;
      const std::string what =
          first->second.file == file ? "" : fmt::format(" (as {}, with the same bytes)", first->second.file);
      throw Error(
          fmt::format("{}: is in {} and in {}{}: a log belongs to one split", file, first->second.split, split, what));
    }
  };
  enter("train_files", splits.train);
  enter("validation_files", splits.validation);
  enter("test_files", splits.test);
  return splits;
}

std::string content_hash(const std::vector<std::string>& files) {
  Fnv1a hash;
  for (const std::string& file : files) hash.add(codegen::read_file(file));
  return hash.hex();
}

}  // namespace nlo::trainer
