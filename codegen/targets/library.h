// SPDX-License-Identifier: MIT
// Folders that package managers take as they are: the exported header with the headers of the runtime that it includes,
// on microcontrollers the C99 pair where there is one, and a program to start from. Each file comes from a template
// (templates/arduino, templates/zephyr, templates/ros2_control): another one is another template.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

/// A library for the Arduino IDE and PlatformIO, without kernels for vector instructions, which microcontrollers do not
/// have. Throws Error as the exports in it do.
std::vector<NamedText> arduino_library(const PreparedExport& prepared);

/// A module for Zephyr's build system. Throws Error as the exports in it do.
std::vector<NamedText> zephyr_module(const PreparedExport& prepared);

/// A package for ROS 2 with a chainable controller for ros2_control. Throws Error as the header in it does.
std::vector<NamedText> ros2_control_package(const PreparedExport& prepared);

/// Returns the names of the runtime's headers that `text` includes and of those that they include, in order. Headers
/// `left_out` are not followed.
std::vector<std::string> runtime_headers(std::string_view text, std::span<const std::string_view> left_out = {});

}  // namespace nlo::codegen
