// SPDX-License-Identifier: MIT
// Golden files show changes of generated text in a review. NLO_REFRESH_GOLDENS=1 writes them again.
#pragma once

#include <string>

namespace nlo::codegen {

/// Fails, with the first lines that differ, unless `text` equals tests/golden/`file`.
void expect_golden(const std::string& text, const std::string& file);

}  // namespace nlo::codegen
