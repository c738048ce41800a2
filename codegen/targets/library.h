// SPDX-License-Identifier: MIT
// Writes folders that package managers can use: the exported header with the runtime headers that it includes, on
// microcontrollers the C99 pair if there is one, and an example program. Each file comes from a template
// (templates/arduino, templates/zephyr, templates/ros2_control). To add a file, add a template.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

/// Returns a library for the Arduino IDE and PlatformIO. It has no kernels for vector instructions, which
/// microcontrollers do not have. Throws Error if an export in it does.
std::vector<NamedText> arduino_library(const PreparedExport& prepared);

/// Returns a module for Zephyr's build system. Throws Error if an export in it does.
std::vector<NamedText> zephyr_module(const PreparedExport& prepared);

/// Returns a package for ROS 2 with a chainable controller for ros2_control. Throws Error if the header in it does.
std::vector<NamedText> ros2_control_package(const PreparedExport& prepared);

/// Returns the names of the runtime's headers that `text` includes and of those that they include, in order. Headers
/// `left_out` are not followed.
std::vector<std::string> runtime_headers(std::string_view text, std::span<const std::string_view> left_out = {});

}  // namespace nlo::codegen
