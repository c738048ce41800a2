// SPDX-License-Identifier: MIT
#include "trainer/data/log_files.h"

#include <fmt/format.h>

#include <glob.h>
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <regex>
#include <string_view>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/base/number_text.h"

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

/// Escapes glob characters in the name of a directory, which is meant literally.
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
    throw Error(fmt::format("{}: no such directory: give the directory of the logs (--data DIR)", directory));
  std::vector<std::string> files;
  for (const std::string& pattern : patterns) {
    const bool relative = !directory.empty() && !pattern.starts_with('/');
    // An existing name is that file, even if it contains glob characters.
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
  if (config.train_files.empty()) throw Error("[log] train_files names no file: expected at least one training log");
  SplitFiles splits{expand_files(directory, config.train_files), expand_files(directory, config.validation_files),
                    expand_files(directory, config.test_files)};
  struct Place {
    const char* split;
    std::string file;
  };
  std::map<std::string, Place> seen;  // by content, because a copy of a log is the same log
  const auto enter = [&](const char* split, const std::vector<std::string>& files) {
    for (const std::string& file : files) {
      const auto [first, is_new] = seen.try_emplace(content_hash({file}), Place{split, file});
      if (is_new || std::string_view(first->second.split) == split) continue;
      const std::string what =
          first->second.file == file ? "" : fmt::format(" (as {}, with the same bytes)", first->second.file);
      throw Error(fmt::format("{}: is in {} and in {}{}: list each log in only one split", file, first->second.split,
                              split, what));
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

namespace {

Trajectory tail_of(const Trajectory& run, Eigen::Index first, double start_s) {
  Trajectory tail = run.from(first);
  if (first == 0) return tail;
  const std::string behind = fmt::format(" from {} s", shortest_text(start_s));
  tail.source += behind;
  if (!tail.log.empty()) tail.log += behind;
  return tail;
}

}  // namespace

Dataset started_at(const Dataset& logs, const std::vector<double>& from_s) {
  Dataset result = logs;
  result.trajectories.clear();
  for (const double start_s : from_s) {
    if (!(start_s >= 0.0))
      throw codegen::Error(
          fmt::format("--from {}: a start must not be negative, which is before the first sample of a log",
                      shortest_text(start_s)));
    bool any = false;
    double longest_s = 0.0;
    for (const Trajectory& run : logs.trajectories) {
      const double* end = run.time_s.data() + run.samples();
      // A start that differs from a sample only by the rounding of stamps is that sample.
      const double at_s = run.time_s(0) + start_s - 1e-6 * logs.sample_period_s;
      const Eigen::Index first = std::lower_bound(run.time_s.data(), end, at_s) - run.time_s.data();
      longest_s = std::max(longest_s, run.time_s(run.samples() - 1) - run.time_s(0));
      if (run.samples() - first < 2) continue;
      result.trajectories.push_back(tail_of(run, first, start_s));
      any = true;
    }
    if (!any)
      throw codegen::Error(fmt::format("--from {}: the longest log ends after {} s; start before that",
                                       shortest_text(start_s), shortest_text(longest_s)));
  }
  return result;
}

namespace {

/// Compiles patterns whose matching time is bounded by the product of the sizes of pattern and name: without back
/// references, and with a limit on the states, which repetitions multiply: (a{9}){9} has 81. Throws std::regex_error.
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
  // An option of libstdc++. Without it a search may take exponential time, as for ^(a+)+$.
  return std::regex(pattern, std::regex::ECMAScript | std::regex_constants::__polynomial);
}

}  // namespace

std::string file_name(const std::string& path) {
  return path.substr(path.rfind('/') + 1);
}

std::string log_kind(const std::string& name) {
  constexpr std::string_view kDigits = "0123456789", kSeparators = "_-. ";
  std::string kind = name.substr(0, name.rfind('.'));
  if (const std::size_t counter = kind.find_first_not_of(kDigits);
      counter != std::string::npos && counter > 0 && kSeparators.find(kind[counter]) != std::string_view::npos)
    kind.erase(0, counter + 1);
  const std::size_t end = kind.find_last_not_of(kDigits);
  const std::size_t last = end == std::string::npos ? end : kind.find_last_not_of(kSeparators, end);
  kind.erase(last == std::string::npos ? 0 : last + 1);
  return kind;
}

std::vector<std::size_t> deal_groups(const std::vector<LogGroup>& groups, std::size_t folds) {
  std::map<std::string, std::vector<std::size_t>> kinds;
  for (std::size_t g = 0; g < groups.size(); ++g) kinds[groups[g].kind].push_back(g);
  std::vector<std::size_t> fold_of(groups.size());
  std::size_t whole = 0, dealt = 0;
  for (const auto& [kind, members] : kinds) {
    const bool is_left_out_whole = kinds.size() > 1 && 2 * members.size() <= groups.size();
    for (const std::size_t g : members) fold_of[g] = is_left_out_whole ? folds - 1 - whole % folds : dealt++ % folds;
    if (is_left_out_whole) ++whole;
  }
  return fold_of;
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
        throw codegen::Error(
            fmt::format("{} {}: finds nothing in \"{}\"; write a pattern that matches a part of every log's name", key,
                        pattern, name));
      }
    }
  } catch (const std::regex_error& error) {
    if (error.code() == std::regex_constants::error_space || error.code() == std::regex_constants::error_complexity)
      throw codegen::Error(
          fmt::format("{} {}: the pattern is too large, or has a back reference (\\1); write for example \"^[a-z]+\"",
                      key, pattern));
    throw codegen::Error(
        fmt::format("{} {}: is not a regular expression; write for example \"^[a-z]+\"", key, pattern));
  }
  std::vector<LogGroup> result;
  for (auto& [name, members] : groups)
    result.push_back({name, pattern.empty() ? log_kind(name) : name, std::move(members)});
  return result;
}

}  // namespace nlo::trainer
