// SPDX-License-Identifier: MIT
// A model keeps a few hashes of its training logs' rows and the range of each output. With them `nlo evaluate` says
// which of its logs the model has seen, and which exceed the training. Hashes of windows of rows find a log, or a part
// of it, in another log with any time stamps and names. They find mistakes, not forgeries: resampled or rounded rows
// are not found.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "trainer/data/dataset.h"
#include "trainer/data/log_file.h"

namespace nlo::trainer {

/// Rows in a window. Half of them must differ from the one before: a rig at rest repeats its rows in every log.
inline constexpr Eigen::Index kContentWindow = 32;

struct LogContent {
  std::string name;
  Eigen::Index rows = 0;
  std::vector<std::uint64_t> windows;  ///< hash of every such window, sorted, each once
};

/// Hashes of the columns under `headings`, as they are in the file.
LogContent content_of(const LogFile& log, const std::vector<std::string>& headings);

/// Share of the windows of `part` that `whole` holds too, 0 to 1.
double share_found(const std::vector<std::uint64_t>& part, const std::vector<std::uint64_t>& whole);

/// Notes each of `logs` that shares rows with one of `training`. `split`: the use of the logs, such as "test".
void note_shared_rows(const std::vector<LogContent>& training, const std::vector<LogContent>& logs,
                      const std::string& split, std::vector<std::string>& notes);

/// An output that strays this far beyond its training range, as a share of the range, is noted; less is noise.
inline constexpr double kBeyondRange = 0.05;

struct TrainingLogs {
  struct Log {
    std::string name;
    Eigen::Index rows = 0;
    std::vector<std::uint64_t> sketch;  ///< the smallest hashes of its windows: a fair sample of its rows
  };
  struct Range {
    std::string output;
    double low = 0.0, high = 0.0;
  };
  std::vector<Log> logs;
  std::vector<Range> outputs;  ///< without angles that are unwrapped, which turn without end
};

/// Ranges are those of the runs and their mirror images.
TrainingLogs remember(const std::vector<LogContent>& contents, const Dataset& training);

/// One line per output and log; a fact of the model's provenance under kTrainingLogsFact.
inline constexpr std::string_view kTrainingLogsFact = "training_logs";
std::string to_text(const TrainingLogs& logs);

/// Reads it back. Throws codegen::Error on any other text.
TrainingLogs parse_training_logs(std::string_view text);

/// Notes each of `contents` that holds rows of a log that trained the model. A cut of a tenth of a log is missed in one
/// case of five, one of a third in one of 600.
void note_rows_of_training(const TrainingLogs& training, const std::vector<LogContent>& contents,
                           std::vector<std::string>& notes);

/// Notes each output that strays beyond its training range on `logs`: how often, how far, and where worst.
void note_outputs_beyond(const TrainingLogs& training, const Dataset& logs, std::vector<std::string>& notes);

}  // namespace nlo::trainer
