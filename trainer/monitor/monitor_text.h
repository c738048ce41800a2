// SPDX-License-Identifier: MIT
// A study of a monitor for people and for programs.
#pragma once

#include <string>

#include "codegen/model/model.h"
#include "trainer/monitor/monitor_study.h"

namespace nlo::trainer {

/// "innovation_mean"; "" for none.
const char* alarm_name(nlo::Alarm alarm);

std::string monitor_text(const codegen::Monitor& monitor, const MonitorStudy& study);
std::string monitor_json(const codegen::Monitor& monitor, const MonitorStudy& study);

}  // namespace nlo::trainer
