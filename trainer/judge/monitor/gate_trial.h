// SPDX-License-Identifier: MIT
// Shows that a gate does no harm: estimates behind it are compared with estimates without it, on runs that did not set
// it, as trained and where a gate is most likely to be wrong.
#pragma once

#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/base/parallel.h"
#include "trainer/judge/monitor/flown_runs.h"

namespace nlo::trainer {

/// A gate whose error is more than this times the error without it is not shipped.
inline constexpr double kMostGateCost = 1.05;

/// The rms error of one way to fly, in deviations of the states, from the first sample on.
struct GateTrial {
  std::string when;  ///< "as trained", "after a restart", "after a jump of the state", "after a gap"
  double plain = 0.0, gated = 0.0;
  double cost() const { return plain > 0.0 ? gated / plain : 1.0; }
};

struct GateReport {
  std::vector<GateTrial> trials;     ///< of the gate that ships, or of the one that does not
  std::vector<std::string> dropped;  ///< "the gate: 3.2 times the error after a restart"; empty: all ships
};

/// Flies `runs` with and without the gate and the frozen-sensor detection of `monitor`, and switches off in `monitor`
/// each of the two that costs more than kMostGateCost in any way to fly. `gap`: samples that are lost in the middle.
GateReport drop_harmful_gates(const codegen::Model& model, codegen::Monitor& monitor, const std::vector<FlownRun>& runs,
                              Eigen::Index gap, ThreadPool& pool);

}  // namespace nlo::trainer
