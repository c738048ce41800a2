// SPDX-License-Identifier: MIT
#include "trainer/data/guess/split_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "trainer/data/log_files.h"

namespace nlo::trainer {
namespace {

namespace fs = std::filesystem;

/// Returns the common folder of all files, in the spelling of the user.
fs::path common_directory(const std::vector<std::string>& files) {
  fs::path common = fs::path(files.front()).parent_path();
  for (const std::string& file : files) {
    const fs::path other = fs::path(file).parent_path();
    fs::path shared;
    for (auto a = common.begin(), b = other.begin(); a != common.end() && b != other.end() && *a == *b; ++a, ++b)
      shared /= *a;
    common = shared;
  }
  return common;
}

}  // namespace

LogFileSplit split_log_files(std::vector<std::string> files, std::vector<std::string>& notes) {
  LogFileSplit split;
  std::map<std::string, std::string> seen;  // path by contents
  for (const std::string& file : expand_files("", files)) {
    const auto [first, is_new] = seen.emplace(content_hash({file}), file);
    if (is_new)
      split.all.push_back(file);
    else
      notes.push_back(fmt::format("{}: a copy of {}, left out because it would be in two splits", file, first->second));
  }
  const fs::path directory = common_directory(split.all);
  split.directory = directory.string();
  constexpr std::size_t kMany = 10, kEvery = 5;
  const std::size_t count = split.all.size();
  for (std::size_t i = 0; i < count; ++i) {
    const bool many = count >= kMany;
    const bool tests = many ? i % kEvery == kEvery - 1 : count > 2 && i + 1 == count;
    const bool validates = many ? i % kEvery == kEvery - 3 : (count == 2 && i == 1) || (count > 2 && i + 2 == count);
    (tests       ? split.test
     : validates ? split.validation
                 : split.train)
        .push_back(fs::path(split.all[i]).lexically_relative(directory.empty() ? "." : directory).string());
  }
  return split;
}

}  // namespace nlo::trainer
