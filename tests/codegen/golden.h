// SPDX-License-Identifier: MIT
// Goldens make a change of what is generated visible in review. NLO_REFRESH_GOLDENS=1 writes them anew.
#pragma once

#include <string>

namespace nlo::codegen {

/// Fails, with the first lines that differ, unless `text` is what tests/golden/`file` holds.
void expect_golden(const std::string& text, const std::string& file);

}  // namespace nlo::codegen
