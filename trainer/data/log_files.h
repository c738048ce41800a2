// SPDX-License-Identifier: MIT
// Which files a run reads: names and globs below a directory, expanded and sorted, split into training, validation and
// test by file. Neighbouring samples of one log are nearly copies: a log in two splits would report its own training.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/experiment.h"

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

}  // namespace nlo::trainer
