// SPDX-License-Identifier: MIT
#include "codegen/model/monitor.h"

#include <cmath>

namespace nlo::codegen {

int armed_after(const Monitor& monitor, double sample_period_s) {
  return static_cast<int>(std::ceil(monitor.armed_after_s / sample_period_s - 1e-9));
}

}  // namespace nlo::codegen
