// SPDX-License-Identifier: MIT
// C99 text for structures that divide a long step into pieces of about one sample period.
#pragma once

#include <map>
#include <string>

#include "codegen/structures/structure_module.h"

namespace nlo::codegen {

/// Returns the position of a reading between two samples: the expression `part`, or 0 if the reading is held.
std::string c99_part(Hold hold, const std::string& part, const Initialiser& init);

/// Returns the keys of templates/c99/rk4.c.in for a latent system that is not linear and may diverge. `slope` is the
/// template of its equation.
std::map<std::string, std::string> c99_of_rk4(const ExportSource& source, const char* slope);

}  // namespace nlo::codegen
