// SPDX-License-Identifier: MIT
// The observer that the programs of this folder fly.
#pragma once

// C linkage gives them names that the analysis of the stack finds.
extern "C" {
void step_and_estimate();
extern float x_hat[2];
extern const unsigned observer_bytes;
}
