// SPDX-License-Identifier: MIT
// Tests that a gate does no harm. Estimates with and without the gate are compared on runs that were not used to set
// it: as in training, and in situations in which a gate is most likely to be wrong.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/base/parallel.h"
#include "trainer/judge/monitor/flown_runs.h"

namespace nlo::trainer {

/// A gate is not shipped if its error exceeds the error without it by this factor.
inline constexpr double kMostGateCost = 1.05;

/// The rms error in one situation, in deviations of the states, from the first sample on.
struct GateTrial {
  std::string when;  ///< "as trained", "after a restart", "after a jump of the state", "after a gap"
  double plain = 0.0, gated = 0.0;
  double cost() const { return plain > 0.0 ? gated / plain : 1.0; }
};

struct GateReport {
  std::vector<GateTrial> trials;  ///< trials of the gate that ships, or of the one that was dropped
  /// With lost readings: `plain` holds the last reading, `gated` uses the prediction instead. Empty: not tried.
  std::optional<GateTrial> replacing;
  std::vector<std::string> dropped;  ///< "the gate: 3.2 times the error after a restart"; empty: nothing was dropped
};

/// Removes 4 % of the readings in bursts of one to three samples, and runs the observer with and without predictions in
/// their place. Sets Monitor::replaces of all outputs that may be replaced if the error is at least 5 % smaller. Slow
/// outputs and those with may_fail are not replaced: the observer expects them to be missing.
std::optional<GateTrial> replace_lost_readings(const codegen::Model& model, codegen::Monitor& monitor,
                                               const std::vector<FlownRun>& runs, ThreadPool& pool);

/// Runs the observer over `runs` with and without the gate and the frozen-sensor detection of `monitor`. Switches each
/// of the two off in `monitor` if it costs more than kMostGateCost in any situation. `gap`: samples that are lost in
/// the middle.
GateReport drop_harmful_gates(const codegen::Model& model, codegen::Monitor& monitor, const std::vector<FlownRun>& runs,
                              Eigen::Index gap, ThreadPool& pool);

}  // namespace nlo::trainer
