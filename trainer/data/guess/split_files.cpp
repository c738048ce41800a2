// SPDX-License-Identifier: MIT
#include "trainer/data/guess/split_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <string_view>
#include <utility>

#include "trainer/data/guess/heading.h"
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

/// Returns true if a word of the name, without a number at its end, is one of `sought`.
bool has_a_word(const std::string& name, std::initializer_list<std::string_view> sought) {
  return std::ranges::any_of(read_heading(name, {}).words, [sought](const std::string& word) {
    const std::string_view letters = std::string_view(word).substr(0, word.find_last_not_of("0123456789") + 1);
    return std::ranges::find(sought, letters) != sought.end();
  });
}

/// Returns relative names by their words: "test_2.csv", "val/run1.csv". All other names are for training.
LogFileSplit split_by_words(const std::vector<std::string>& names) {
  LogFileSplit split;
  for (const std::string& name : names)
    (has_a_word(name, {"test", "testing"})                          ? split.test
     : has_a_word(name, {"validation", "validate", "valid", "val"}) ? split.validation
                                                                    : split.train)
        .push_back(name);
  return split;
}

/// Moves some of the files for training to the test and to the validation, whichever have none yet.
void split_by_number(LogFileSplit& split) {
  constexpr std::size_t kMany = 10, kEvery = 5;
  const std::vector<std::string> names = std::exchange(split.train, {});
  const std::size_t count = names.size();
  const bool many = count >= kMany, wants_test = split.test.empty(), wants_validation = split.validation.empty();
  const std::size_t last_for_test = wants_test && count > 2 ? 1 : 0;
  for (std::size_t i = 0; i < count; ++i) {
    const bool tests = wants_test && (many ? i % kEvery == kEvery - 1 : i + last_for_test == count);
    const bool validates =
        wants_validation && (many ? i % kEvery == kEvery - 3 : count > 1 && i + 1 + last_for_test == count);
    (tests ? split.test : validates ? split.validation : split.train).push_back(names[i]);
  }
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
  std::vector<std::string> names;
  for (const std::string& file : split.all)
    names.push_back(fs::path(file).lexically_relative(directory.empty() ? "." : directory).string());
  LogFileSplit kinds = split_by_words(names);
  if (kinds.train.empty()) {
    kinds = {};
    kinds.train = names;
  }
  split_by_number(kinds);
  split.train = std::move(kinds.train);
  split.validation = std::move(kinds.validation);
  split.test = std::move(kinds.test);
  return split;
}

}  // namespace nlo::trainer
