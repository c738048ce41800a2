// SPDX-License-Identifier: MIT
// Does a model fit a microcontroller? Constants, RAM and multiply-adds follow from the model; code and stack come from
// a table that is calibrated on linked programs and held against them by tests/embedded/fit.sh.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "codegen/export/prepared_export.h"

namespace nlo::codegen {

/// What there is for the observer; nothing: not limited.
struct Budget {
  std::optional<Eigen::Index> flash, ram;     ///< bytes
  std::optional<Eigen::Index> multiply_adds;  ///< per step and estimate
  std::string core;                           ///< only this one counts; empty: all of them
};

/// "flash=32K,ram=2K,mac=5000,core=m4f", any subset. K and M are 1024 and 1024^2 bytes. Throws Error.
Budget budget(const std::string& text);

/// What the observer in a C++ header takes on a core, at -O2: upper bounds.
struct Need {
  std::string core, title;     ///< "m4f", "M4F"
  Eigen::Index constants = 0;  ///< bytes of flash
  Eigen::Index code = 0;       ///< bytes of flash, with start-up code and a main loop; M0+: the emulation of floats too
  Eigen::Index observer = 0;   ///< bytes of RAM
  Eigen::Index stack = 0;      ///< bytes of RAM below the caller of step() and estimate()
  Eigen::Index multiply_adds = 0;

  Eigen::Index flash() const { return constants + code; }
  Eigen::Index ram() const { return observer + stack; }
};

/// One for each core. Throws Error for what the table does not know: double, structures that are not calibrated.
std::vector<Need> needs(const PreparedExport& prepared);

std::string needs_table(const std::vector<Need>& needs);

/// Empty when the model fits; else what is short, on which core, by how much.
std::string shortfall(const std::vector<Need>& needs, const Budget& budget);

}  // namespace nlo::codegen
