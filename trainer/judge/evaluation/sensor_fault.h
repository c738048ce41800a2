// SPDX-License-Identifier: MIT
// A sensor that fails in a log, and stays so: it is missing, repeats its last reading, or reads zero.
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
  double after_s = 0.0;  ///< since the first sample of a log
};

/// "OUTPUT", "OUTPUT:stuck" or "OUTPUT:dead", and behind it ":SECONDS". Throws codegen::Error for other words.
SensorFault parse_fault(std::string_view word);

/// As parse_fault() reads it.
std::string format_fault(const SensorFault& fault);

/// Only those where the observer is told that the sensor is missing.
std::vector<SensorFault> missing_alone(const std::vector<SensorFault>& faults);

/// The logs with these faults, and with outputs that are computed from the faulty sensors. Throws codegen::Error where
/// there is no such output.
Dataset with_faults(Dataset logs, const std::vector<SensorFault>& faults);

}  // namespace nlo::trainer
