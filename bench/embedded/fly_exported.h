// SPDX-License-Identifier: MIT
// The interface of fly_log.cpp to its observer, which is compiled separately so that the instructions and the stack of
// a step can be measured.
#pragma once

// C linkage gives the names that the analysis of the stack expects.
extern "C" {
/// Sizes of an exported observer.
struct FlownObserver {
  int outputs, inputs, states;
  unsigned bytes;  ///< RAM
};
extern const FlownObserver flown;

/// Steps by dt_s (0: the sample period), writes an estimate into x_hat, and returns the status of the step.
int step_and_estimate(float dt_s, const float* y, const float* u, float* x_hat);
bool in_domain();
}
