// SPDX-License-Identifier: MIT
#include "trainer/data/log_groups.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <regex>

#include "codegen/base/error.h"

namespace nlo::trainer {
namespace {

/// For patterns whose matching takes no more than the product of theirs and the name's size: no references back, and
/// not too many states, which counts multiply: of (a{9}){9} there are 81. Throws std::regex_error.
std::regex bounded_regex(const std::string& pattern) {
  constexpr std::size_t kLongestPattern = 200;
  constexpr double kMostCopies = 1000.0;
  double copies = 1.0;
  for (std::size_t at = pattern.find('{'); at != std::string::npos; at = pattern.find('{', at + 1)) {
    double most = 1.0;
    for (const char* c = pattern.c_str() + at + 1; *c != '\0' && *c != '}';) {
      char* end = nullptr;
      most = std::max(most, std::strtod(c, &end));
      c = end == c ? c + 1 : end;
    }
    copies *= most;
  }
  if (pattern.size() > kLongestPattern || !(copies <= kMostCopies))
    throw std::regex_error(std::regex_constants::error_space);
  // Of libstdc++: without it a search may go back and forth for longer than anybody waits, ^(a+)+$ for one.
  return std::regex(pattern, std::regex::ECMAScript | std::regex_constants::__polynomial);
}

}  // namespace

std::string file_name(const std::string& path) {
  return path.substr(path.rfind('/') + 1);
}

std::vector<LogGroup> log_groups(const std::vector<std::string>& files, const std::string& pattern,
                                 const std::string& key) {
  std::map<std::string, std::vector<std::string>> groups;
  try {
    const std::regex regex = bounded_regex(pattern);
    for (const std::string& file : files) {
      const std::string name = file_name(file);
      std::smatch match;
      if (pattern.empty()) {
        groups[name].push_back(file);
      } else if (std::regex_search(name, match, regex)) {
        groups[match[match.size() > 1 ? 1 : 0].str()].push_back(file);
      } else {
        throw codegen::Error(fmt::format("{} {}: finds nothing in \"{}\"; write a pattern that every log's name has",
                                         key, pattern, name));
      }
    }
  } catch (const std::regex_error& error) {
    if (error.code() == std::regex_constants::error_space || error.code() == std::regex_constants::error_complexity)
      throw codegen::Error(fmt::format(
          "{} {}: is too large a pattern, or refers back (\\1); write for example \"^[a-z]+\"", key, pattern));
    throw codegen::Error(
        fmt::format("{} {}: is not a regular expression; write for example \"^[a-z]+\"", key, pattern));
  }
  std::vector<LogGroup> result;
  for (auto& [name, members] : groups) result.push_back({name, std::move(members)});
  return result;
}

}  // namespace nlo::trainer
