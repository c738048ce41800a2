// SPDX-License-Identifier: MIT
// Maps the columns of a log to the channels of a Dataset: the [[log.columns]] of an experiment, checked and resolved
// once for the loader, the baselines and the metrics.
#pragma once

#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/data/csv.h"
#include "trainer/data/dataset.h"
#include "trainer/data/log_column.h"

namespace nlo::trainer {

/// Relation of a state to the measured outputs, from which a causal differentiator starts.
enum class StateKind { kHidden, kMeasured, kSineOfMeasured, kCosineOfMeasured, kDerivativeOfMeasured };

struct StateSource {
  StateKind kind = StateKind::kHidden;
  int output = -1;    ///< channel that measures it (its sine when `cosine` is set); -1: hidden
  int cosine = -1;    ///< channel that measures the cosine; -1: `output` is the quantity itself
  double wrap = 0.0;  ///< full turn of the measured quantity; 0: not an angle
};

/// Neighbouring states that are one angle: two states, its sine and cosine; or three, a vector whose direction counts.
struct AnglePair {
  std::string name, unit;
  double wrap = 0.0;
  int sine = 0;        ///< index of the first state
  int components = 2;  ///< 3: the angle between two such vectors [deg]
};

struct LogSchema {
  CsvFormat format;                                ///< format of the files
  std::vector<std::string> missing;                ///< cells that mean no value in any column
  std::string time_heading;                        ///< empty: no time stamps, rows are sample_period_s apart
  double time_unit_s = 1.0;                        ///< seconds per unit of the time column
  bool has_time_unit = false;                      ///< true if a unit is given; else seconds are assumed
  std::vector<LogColumn> outputs, states, inputs;  ///< columns of the file
  std::vector<LogColumn> masks;                    ///< the truth of a row counts if none of them is 0
  /// Computed outputs follow those of the file.
  std::vector<codegen::Channel> output_channels, state_channels, input_channels;
  std::vector<StateSource> state_sources;  ///< one per state channel
  std::vector<AnglePair> angle_pairs;      ///< among the states
};

/// Returns the format of the rows in the files of a [log]. Throws KeyError if separator and decimal mark are the same.
CsvFormat format_of(const LogConfig& config);

/// Resolves the columns. Throws KeyError with the column and the remedy for: no output, no state, two time columns, a
/// name that is used twice, an encoding without a wrap, a derivative of an unlisted column; and for [log] if a comma
/// separates both cells and decimals.
LogSchema resolve_columns(const LogConfig& config);

}  // namespace nlo::trainer
