// SPDX-License-Identifier: MIT
// Finds the files of a run: names and globs below a directory, expanded and sorted, split into training, validation and
// test by file. Neighbouring samples of one log are nearly equal, so a log in two splits would be tested on its own
// training data. The file also has functions to start logs in their middle, because an observer may be switched on at
// any time, and to group similar logs, so that they are left out together.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// Returns the paths that match the names or globs (glob(7): * ? []) below `directory` (empty: as given), sorted and
/// once each. Throws codegen::Error with pattern and directory if one matches no file.
std::vector<std::string> expand_files(const std::string& directory, const std::vector<std::string>& patterns);

struct SplitFiles {
  std::vector<std::string> train, validation, test;
};

/// Returns the three splits of `config` below `directory`. Throws codegen::Error if training has no files, or if a file
/// or a copy of it is in two splits. Validation and test may be empty.
SplitFiles expand_splits(const LogConfig& config, const std::string& directory);

/// Returns the FNV-1a hash (64 bit, 16 hex digits) of the files' bytes and lengths in the given order. A model stores
/// it to identify its training data. Names and folders do not matter. It detects mistakes, not forgeries.
std::string content_hash(const std::vector<std::string>& files);

/// Returns each run once for each of `from_s` [s since its first sample]: from there to its end, with time and latent
/// state starting there. A run with fewer than two samples left is left out. Throws codegen::Error if a start is
/// negative or beyond all runs.
Dataset started_at(const Dataset& logs, const std::vector<double>& from_s);

struct LogGroup {
  std::string name;
  std::string kind;  ///< logs of one kind are alike (log_kind)
  std::vector<std::string> files;
};

/// Returns the last part of a path.
std::string file_name(const std::string& path);

/// Returns the kind of a log from its file name: the name without its extension, without a counter at its end, and
/// without a counter before its first separator. "rubber_07.csv" is of the kind "rubber", "01_fast_A.csv" of "fast_A",
/// "0degC_Mixed2.csv" of "0degC_Mixed".
std::string log_kind(const std::string& name);

/// Distributes groups over `folds` sets that are left out in turn, and returns the set of each group. All groups of a
/// kind that has at most half of the groups are in one set, so that the set shows the errors on a kind that a training
/// has not seen. A kind with more groups is distributed over all sets, because without it too little training data
/// would be left. Groups with neighbouring names, which are often similar, are in different sets.
std::vector<std::size_t> deal_groups(const std::vector<LogGroup>& groups, std::size_t folds);

/// Returns groups of files, sorted by the text that the regular expression `pattern` finds in their names (the first
/// capture, or the whole match). Files with the same text form one group, and each group is a kind. Without a pattern,
/// each file is a group. `key`: the option or key with the pattern, for messages. Throws codegen::Error for a pattern
/// that is wrong, too large, or finds nothing in a name.
std::vector<LogGroup> log_groups(const std::vector<std::string>& files, const std::string& pattern,
                                 const std::string& key);

}  // namespace nlo::trainer
