// SPDX-License-Identifier: MIT
// A permanent fault of a sensor in a log: it is missing, repeats its last reading, or reads zero.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "trainer/data/dataset.h"

namespace nlo::trainer {

struct SensorFault {
  enum class Kind { kMissing, kStuck, kDead };
  std::string output;
  Kind kind = Kind::kMissing;
  double after_s = 0.0;  ///< start of the fault since the first sample of a log
};

/// Reads "OUTPUT", "OUTPUT:stuck" or "OUTPUT:dead", with or without ":SECONDS". Throws codegen::Error for other words.
SensorFault parse_fault(std::string_view word);

/// Returns the text that parse_fault() reads.
std::string format_fault(const SensorFault& fault);

/// Returns only the faults that the observer knows: missing sensors.
std::vector<SensorFault> missing_alone(const std::vector<SensorFault>& faults);

/// Returns the logs with these faults, and with outputs that are computed from the faulty sensors. Throws
/// codegen::Error if there is no such output.
Dataset with_faults(Dataset logs, const std::vector<SensorFault>& faults);

}  // namespace nlo::trainer
