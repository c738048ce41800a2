// SPDX-License-Identifier: MIT
// Shows which faults of a sensor raise an alarm: each output fails in the middle of runs that set no limit.
#pragma once

#include <nlo/monitor_model.h>

#include <optional>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/base/parallel.h"
#include "trainer/judge/monitor/flown_runs.h"

namespace nlo::trainer {

enum class Fault { kDead, kFrozen, kZero, kBiased, kNoisy };
const char* fault_name(Fault fault);

/// One fault of one output. A run is harmed if the fault doubles its error from then on.
struct FaultRow {
  std::string output;
  Fault fault = Fault::kDead;
  double error = 0.0;                    ///< rms with the fault over that without, from the fault on
  int harmed = 0, seen = 0;              ///< runs that are harmed, and those of them with an alarm from the fault on
  std::optional<double> median_delay_s;  ///< from the fault to the alarm, over the runs that are seen
  nlo::Alarm most = nlo::Alarm::kNone;   ///< the commonest first alarm

  /// A dead, frozen or zero sensor that does harm without an alarm in more than a tenth of the runs.
  bool undetected() const;
};

/// Rows for each measured output and fault. A bias is half a deviation of the output, noise is twice a deviation.
std::vector<FaultRow> try_faults(const codegen::Model& model, const codegen::Monitor& monitor,
                                 const std::vector<FlownRun>& runs, ThreadPool& pool);

}  // namespace nlo::trainer
