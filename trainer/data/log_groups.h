// SPDX-License-Identifier: MIT
// Logs that belong together: what is like a log that is left out should be left out with it.
#pragma once

#include <string>
#include <vector>

namespace nlo::trainer {

struct LogGroup {
  std::string name;
  std::vector<std::string> files;
};

/// A path's last part.
std::string file_name(const std::string& path);

/// One group for each text that the regular expression `pattern` finds in the files' names (its first group, or all of
/// the match), sorted by that text; without a pattern one for each file. `key`: who gave the pattern, for messages.
/// Throws codegen::Error for a pattern that is wrong, too large, or finds nothing in a name.
std::vector<LogGroup> log_groups(const std::vector<std::string>& files, const std::string& pattern,
                                 const std::string& key);

}  // namespace nlo::trainer
