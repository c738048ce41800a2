// SPDX-License-Identifier: MIT
// Which rows a log holds, by hashes of windows of them: finds a log, or a cut of it, in another, whatever their time
// stamps and names are. It finds mistakes, not forgeries: rows that were resampled or rounded anew are other rows.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "trainer/data/log_file.h"

namespace nlo::trainer {

/// Rows in a window. Half of them must differ from the one before: a rig at rest repeats its rows in every log.
inline constexpr Eigen::Index kContentWindow = 32;

struct LogContent {
  std::string name;
  Eigen::Index rows = 0;
  std::vector<std::uint64_t> windows;  ///< hash of every such window, sorted, each once
};

/// Of the columns under `headings`, as they stand in the file.
LogContent content_of(const LogFile& log, const std::vector<std::string>& headings);

/// Share of the windows of `part` that `whole` holds too, 0 to 1.
double share_found(const std::vector<std::uint64_t>& part, const std::vector<std::uint64_t>& whole);

/// Notes each of `logs` that shares rows with one of `training`. `split`: what the logs are there for, as "test".
void note_shared_rows(const std::vector<LogContent>& training, const std::vector<LogContent>& logs,
                      const std::string& split, std::vector<std::string>& notes);

}  // namespace nlo::trainer
