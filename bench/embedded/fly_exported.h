// SPDX-License-Identifier: MIT
// The interface of fly_log.cpp to its observer, which is compiled separately so that the instructions and the stack of
// a step can be measured.
#pragma once

// C linkage gives the names that the analysis of the stack finds.
extern "C" {
/// Sizes of an exported observer.
struct FlownObserver {
  int outputs, inputs, states;
  unsigned bytes;  ///< RAM
};
extern const FlownObserver flown;

/// A step by dt_s, 0 standing for the sample period, and an estimate into x_hat; the step's status.
int step_and_estimate(float dt_s, const float* y, const float* u, float* x_hat);
bool in_domain();
}
