// SPDX-License-Identifier: MIT
// Tests which sensor faults raise an alarm: each output fails in the middle of runs that were not used for the limits.
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

/// One fault of one output. A fault harms a run if it doubles the error from then on.
struct FaultRow {
  std::string output;
  Fault fault = Fault::kDead;
  double error = 0.0;                    ///< ratio of the rms error with the fault to that without, from the fault on
  int harmed = 0, seen = 0;              ///< number of harmed runs, and of those with an alarm after the fault
  std::optional<double> median_delay_s;  ///< from the fault to the alarm, over the runs with an alarm
  nlo::Alarm most = nlo::Alarm::kNone;   ///< most frequent first alarm

  /// Returns true for a dead, frozen or zero sensor that does harm without an alarm in more than a tenth of the runs.
  bool undetected() const;
};

/// Returns a row for each measured output and fault. A bias is half a deviation of the output, noise is two deviations.
std::vector<FaultRow> try_faults(const codegen::Model& model, const codegen::Monitor& monitor,
                                 const std::vector<FlownRun>& runs, ThreadPool& pool);

}  // namespace nlo::trainer
