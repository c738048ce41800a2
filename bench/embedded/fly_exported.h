// SPDX-License-Identifier: MIT
// What fly_log.cpp knows of the observer that it flies: a compilation of its own, so that its step can be counted and
// its stack be looked at.
#pragma once

// C linkage gives the names that the analysis of the stack finds.
extern "C" {
/// Sizes of an exported observer.
struct FlownObserver {
  int outputs, inputs, states;
  unsigned bytes;  ///< of RAM
};
extern const FlownObserver flown;

/// A step by dt_s, 0 standing for the sample period, and an estimate into x_hat; the step's status.
int step_and_estimate(float dt_s, const float* y, const float* u, float* x_hat);
bool in_domain();
}
