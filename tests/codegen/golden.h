// SPDX-License-Identifier: MIT
// Golden files make changes of generated text visible in a review. NLO_REFRESH_GOLDENS=1 writes them again.
#pragma once

#include <string>

namespace nlo::codegen {

/// Fails, with the first lines that differ, unless `text` is what tests/golden/`file` holds.
void expect_golden(const std::string& text, const std::string& file);

}  // namespace nlo::codegen
