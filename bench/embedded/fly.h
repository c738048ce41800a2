// SPDX-License-Identifier: MIT
// The observer that the programs of this folder run.
#pragma once

// C linkage gives the functions the names that the analysis of the stack expects.
extern "C" {
void step_and_estimate();
extern float x_hat[2];
extern const unsigned observer_bytes;
}
