// SPDX-License-Identifier: MIT
// The observer on logs of a real rig, beside what a user would do without one.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "codegen/model.h"
#include "trainer/analysis/evaluate.h"
#include "trainer/analysis/metrics.h"
#include "trainer/data/dataset.h"
#include "trainer/data/log_metrics.h"
#include "trainer/data/log_schema.h"
#include "trainer/noise.h"

namespace nlo::trainer {

struct LogEvaluation {
  struct Entry {
    std::string estimator;              ///< "observer", then LogBaseline::names()
    std::vector<std::string> describe;  ///< per state, how this estimator was set up; empty for the observer
    LogMetrics metrics;
  };
  std::vector<Entry> entries;      ///< the observer first
  ErrorMetrics metrics;            ///< of the observer over all files; `norm` adds up the states' units as they are
  bool one_unit = true;            ///< all states share a unit: only then is `norm` a physical quantity
  std::vector<std::string> notes;  ///< plain words on states that are not estimated better than by a constant
  NoiseConfig noise;               ///< added to the logged outputs
  std::uint64_t seed = 0;
  std::string split;                ///< "test", "validation" or "training" of an experiment; empty: other logs
  std::string baselines_fitted_on;  ///< "the training logs", "these logs"
  std::vector<Channel> states, outputs;
  std::vector<EvaluatedRun> examples;  ///< all logs, or kMostExamples of them (examples.h); the first is the first
};

/// A state whose error after 2 s exceeds this share of the constant predictor's is called out as not seen.
inline constexpr double kNoBetterThanConstant = 0.95;

/// Runs the model and the baselines over every log, with `noise` added to the measured outputs.
///   baseline_logs  what the baselines may learn from: the training logs; or nullptr, then the very logs they are
///   judged
///                  on, in hindsight, which only makes them harder to beat
LogEvaluation evaluate_on_logs(const codegen::Model& model, const Dataset& logs, const LogSchema& schema,
                               const Dataset* baseline_logs, const NoiseConfig& noise, std::uint64_t seed);

}  // namespace nlo::trainer
