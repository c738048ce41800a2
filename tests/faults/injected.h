// SPDX-License-Identifier: MIT
// Runs the program with inject.c, lists the calls that it makes, and compares the files of two runs.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/commands/program.h"

namespace nlo::trainer {

using Words = std::vector<std::string>;
using Files = std::map<std::string, std::string>;

/// Sets environment variables for the programs that are started during its lifetime.
class Environment {
 public:
  explicit Environment(std::map<std::string, std::string> variables) : variables_(std::move(variables)) {
    for (const auto& [name, value] : variables_) ::setenv(name.c_str(), value.c_str(), 1);
  }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;
  ~Environment() {
    for (const auto& variable : variables_) ::unsetenv(variable.first.c_str());
  }

 private:
  std::map<std::string, std::string> variables_;
};

inline ProgramResult run_with(const Scratch& scratch, const Words& command, const std::string& fault) {
  const Environment environment({{"LD_PRELOAD", NLO_INJECT}, {"NLO_FAULT", fault}});
  return scratch.run(command);
}

struct Counts {
  long allocations = 0, calls = 0;
};

inline Counts counts_of(const Scratch& scratch, const Words& command) {
  const std::string file = scratch.path() + ".counts";
  Counts counts;
  {
    const Environment environment({{"LD_PRELOAD", NLO_INJECT}, {"NLO_FAULT_COUNT", file}});
    const ProgramResult result = scratch.run(command);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
  std::ifstream(file) >> counts.allocations >> counts.calls;
  std::filesystem::remove(file);
  EXPECT_GT(counts.allocations, 0);
  return counts;
}

/// Returns about `some` of the numbers 1 ... count, always with the first and the last three.
inline std::vector<long> tried(long count, long some) {
  some = std::min(some, count);
  const long ends = std::min(some, 3L);
  std::vector<long> result;
  for (long n = 1; n <= count; ++n)
    if (n <= ends || n > count - ends || n * some / count != (n - 1) * some / count) result.push_back(n);
  return result;
}

/// Returns whether a name has the form NAME.nlo-XXXXXX; lib/.nlo-export is not temporary.
inline bool is_temporary(const std::string& name) {
  const auto at = name.find(".nlo-");
  return at != std::string::npos && at > 0 && name[at - 1] != '/';
}

/// Returns the files of a folder for comparisons. A file that contains times is represented by its last bytes, which
/// show whether it is complete.
inline Files comparable(Files files) {
  for (auto it = files.begin(); it != files.end();) {
    const auto& [name, bytes] = *it;
    if (is_temporary(name) || name.ends_with("metrics.csv") || name.ends_with("checkpoint.bin")) {
      it = files.erase(it);
      continue;
    }
    for (const char* timed : {"report.html", "run.json", "auto.html", "compare.html", "compare.json"})
      if (name.ends_with(timed)) it->second = bytes.substr(std::max<std::size_t>(bytes.size(), 9) - 9);
    ++it;
  }
  return files;
}

/// Returns whether the failed call, named on stderr, was meant to remove a file.
inline bool removes(const std::string& err) {
  for (const char* call : {"unlink", "unlinkat", "rmdir", "remove"})
    if (err.find(std::string("fault: ") + call + "\n") != std::string::npos) return true;
  return false;
}

}  // namespace nlo::trainer
