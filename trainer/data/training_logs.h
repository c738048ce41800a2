// SPDX-License-Identifier: MIT
// A model stores some hashes of the rows of its training logs and the range of each output. With them `nlo evaluate`
// finds logs that the model was trained on, and outputs that exceed the training range. Hashes of windows of rows
// recognise a log, or a part of it, in another log with any time stamps and names. They detect mistakes, not forgeries:
// resampled or rounded rows are not found.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "trainer/data/dataset.h"
#include "trainer/data/log_file.h"

namespace nlo::trainer {

/// Rows in a window. Half of them must differ from the row before, because a rig at rest repeats its rows in every log.
inline constexpr Eigen::Index kContentWindow = 32;

struct LogContent {
  std::string name;
  Eigen::Index rows = 0;
  std::vector<std::uint64_t> windows;  ///< hashes of all such windows, sorted, each once
};

/// Returns hashes of the columns under `headings`, with the cells of the file.
LogContent content_of(const LogFile& log, const std::vector<std::string>& headings);

/// Returns the share of the windows of `part` that `whole` also has, 0 to 1.
double share_found(const std::vector<std::uint64_t>& part, const std::vector<std::uint64_t>& whole);

/// Adds a note for each of `logs` that shares rows with one of `training`. `split`: the use of the logs, such as
/// "test".
void note_shared_rows(const std::vector<LogContent>& training, const std::vector<LogContent>& logs,
                      const std::string& split, std::vector<std::string>& notes);

/// An output that exceeds its training range by more than this share of the range gets a note; less is noise.
inline constexpr double kBeyondRange = 0.05;

struct TrainingLogs {
  struct Log {
    std::string name;
    Eigen::Index rows = 0;
    std::vector<std::uint64_t> sketch;  ///< the smallest hashes of its windows, which are a random sample of its rows
  };
  struct Range {
    std::string output;
    double low = 0.0, high = 0.0;
  };
  std::vector<Log> logs;
  std::vector<Range> outputs;  ///< without unwrapped angles, which have no range
};

/// Returns what a model remembers: the hashes of its training logs and the range of each output in `training`, mirror
/// images included.
TrainingLogs remember(const std::vector<LogContent>& contents, const Dataset& training);

/// Name of the fact of a model's provenance that has the text: one line per output and log.
inline constexpr std::string_view kTrainingLogsFact = "training_logs";
std::string to_text(const TrainingLogs& logs);

/// Reads the text of to_text(). Throws codegen::Error for any other text.
TrainingLogs parse_training_logs(std::string_view text);

/// Adds a note for each of `contents` that has rows of a log that trained the model. A part of a tenth of a log is
/// missed in one case of five, a part of a third in one of 600.
void note_rows_of_training(const TrainingLogs& training, const std::vector<LogContent>& contents,
                           std::vector<std::string>& notes);

/// Adds a note for each output that exceeds its training range on `logs`: how often, how far, and where it is largest.
void note_outputs_beyond(const TrainingLogs& training, const Dataset& logs, std::vector<std::string>& notes);

}  // namespace nlo::trainer
