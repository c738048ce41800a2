// SPDX-License-Identifier: MIT
#include "codegen/model/monitor_parameters.h"

#include <cmath>

namespace nlo::codegen {

int armed_after(const Monitor& monitor, double sample_period_s) {
  return static_cast<int>(std::ceil(monitor.armed_after_s / sample_period_s - 1e-9));
}

void leave_out_frozen(Monitor& monitor, Eigen::Index outputs) {
  for (Eigen::VectorXd* each : {&monitor.most_equal, &monitor.resting, &monitor.reference_sensor, &monitor.rest_min,
                                &monitor.rest_max, &monitor.most_moved})
    each->setZero(outputs);
}

void leave_out_motion_and_row(Monitor& monitor, Eigen::Index outputs, Eigen::Index states, Eigen::Index features) {
  monitor.motion.setZero(outputs);
  monitor.row.setZero(states, features);
  for (Eigen::VectorXd* each : {&monitor.row_offset, &monitor.row_deviation, &monitor.disagreement_limit})
    each->setZero(states);
}

}  // namespace nlo::codegen
