// SPDX-License-Identifier: MIT
// Which files a run reads: names and globs below a directory, expanded and sorted, split into training, validation and
// test by file. Neighbouring samples of one log are nearly copies: a log in two splits would report its own training.
// Logs begun in their middle: an observer may be switched on at any time, and most logs begin where it is easy.
// Groups of logs: logs that are alike should be left out together.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// Paths that match the names or globs (glob(7): * ? []) below `directory` (empty: as they stand), in sorted order and
/// once each. Throws codegen::Error naming pattern and directory when one of them matches no file.
std::vector<std::string> expand_files(const std::string& directory, const std::vector<std::string>& patterns);

struct SplitFiles {
  std::vector<std::string> train, validation, test;
};

/// The three splits of `config` below `directory`. Throws codegen::Error when training has no files, or when a file, or
/// a copy of it, is in two splits. Validation and test may be empty.
SplitFiles expand_splits(const LogConfig& config, const std::string& directory);

/// FNV-1a (64 bit, 16 hex digits) over the files' bytes and lengths in the order given: says in a model which data it
/// was trained on. Names and folders do not enter. It finds mistakes, not forgeries.
std::string content_hash(const std::vector<std::string>& files);

/// Each run once for each of `from_s` [s since its first sample]: from there to its end, with time and latent state
/// counted from there. A run that has not two samples left is left out. Throws codegen::Error when a start is negative
/// or beyond all runs.
Dataset started_at(const Dataset& logs, const std::vector<double>& from_s);

struct LogGroup {
  std::string name;
  std::string kind;  ///< logs of one kind are alike (log_kind)
  std::vector<std::string> files;
};

/// A path's last part.
std::string file_name(const std::string& path);

/// Returns the kind of a log by its file name: the name without extension, without a counter at its end and without one
/// before its first separator. "rubber_07.csv" is of the kind "rubber", "01_fast_A.csv" of "fast_A", "0degC_Mixed2.csv"
/// of "0degC_Mixed".
std::string log_kind(const std::string& name);

/// Deals groups to `folds` sets that are left out in turn, and returns the set of each group. A kind with at most half
/// of the groups is left out whole, so that a set shows how well a training does on a kind that it has not seen. A kind
/// with more is dealt in turn, because without it too little would be left to train on; neighbours by name, which are
/// often alike, come into different sets.
std::vector<std::size_t> deal_groups(const std::vector<LogGroup>& groups, std::size_t folds);

/// One group for each text that the regular expression `pattern` finds in the files' names (its first group, or all of
/// the match), sorted by that text; without a pattern one for each file. With a pattern
/// each group is a kind. `key`: who gave the pattern, for messages.
/// Throws codegen::Error for a pattern that is wrong, too large, or finds nothing in a name.
std::vector<LogGroup> log_groups(const std::vector<std::string>& files, const std::string& pattern,
                                 const std::string& key);

}  // namespace nlo::trainer
