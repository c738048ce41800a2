// SPDX-License-Identifier: MIT
// How the channels of a Dataset come from the columns of a log: the [[log.columns]] of an experiment, checked and
// resolved once for the loader, the baselines and the metrics.
#pragma once

#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/data/csv.h"
#include "trainer/data/dataset.h"
#include "trainer/data/log_column.h"

namespace nlo::trainer {

/// Relation of a state to the measured outputs: the start of a causal differentiator.
enum class StateKind { kHidden, kMeasured, kSineOfMeasured, kCosineOfMeasured, kDerivativeOfMeasured };

struct StateSource {
  StateKind kind = StateKind::kHidden;
  int output = -1;    ///< channel that measures it (its sine when `cosine` is set); -1: hidden
  int cosine = -1;    ///< channel that measures the cosine; -1: `output` is the quantity itself
  double wrap = 0.0;  ///< full turn of the measured quantity; 0: not an angle
};

/// Neighbouring states that are one angle: two, its sine and cosine; or three, a vector whose direction counts.
struct AnglePair {
  std::string name, unit;
  double wrap = 0.0;
  int sine = 0;        ///< index of the first state
  int components = 2;  ///< 3: the angle is that between two such vectors [deg]
};

struct LogSchema {
  CsvFormat format;                                ///< format of the files
  std::vector<std::string> missing;                ///< cells that stand for no value in any column
  std::string time_heading;                        ///< empty: no time stamps, rows are sample_period_s apart
  double time_unit_s = 1.0;                        ///< seconds per unit of the time column
  bool has_time_unit = false;                      ///< it was given; else seconds are assumed
  std::vector<LogColumn> outputs, states, inputs;  ///< columns of the file
  std::vector<LogColumn> masks;                    ///< the truth of a row counts where none of them is 0
  /// Outputs that are computed stand behind those of the file.
  std::vector<codegen::Channel> output_channels, state_channels, input_channels;
  std::vector<StateSource> state_sources;  ///< one per state channel
  std::vector<AnglePair> angle_pairs;      ///< among the states
};

/// How the files of a [log] write their rows. Throws KeyError where separator and decimal are the same.
CsvFormat format_of(const LogConfig& config);

/// Throws KeyError with the column and the remedy: no output, no state, two time columns, a name that is taken, an
/// encoding without a wrap, a derivative of an unlisted column; and for [log] if a comma separates both cells and
/// decimals.
LogSchema resolve_columns(const LogConfig& config);

}  // namespace nlo::trainer
