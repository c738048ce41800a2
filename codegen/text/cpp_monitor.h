// SPDX-License-Identifier: MIT
// The monitor of a model in generated text: its constants, and its part of a C++ header.
#pragma once

#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {

/// A constant of a nlo::MonitorModel. C and C++ initialise it in the same way.
struct MonitorConstant {
  const char *name, *type, *extents;  ///< "gain", "Scalar", "[kWindows]"
  std::string field;                  ///< field of the model: "monitor.windows_s"
  Eigen::MatrixXd values;
  std::string text;

  bool is_integer() const { return std::string_view(type) != "Scalar"; }
};

/// Returns the constants of the monitor. The model must have one, as for all functions here.
std::vector<MonitorConstant> monitor_constants(const Model& model, const Initialiser& init);

/// Returns a comment that states the rate of false alarms for which the limits were set.
std::string monitor_promise(const Monitor& monitor);

std::string cpp_monitor(const Model& model, const Initialiser& init);

}  // namespace nlo::codegen
