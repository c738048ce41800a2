// SPDX-License-Identifier: MIT
// The observer whose calls seen.cpp counts. A compilation of its own, so that no call is inlined into the count.
#pragma once

/// The observer whose calls are counted, and its monitor where it has one. `state`: their bytes behind the first
/// pointer to a model; `pointer`: where the second is in them, at the end where there is none.
struct CalledObserver {
  int outputs, inputs;
  unsigned char* state;
  unsigned bytes;
  float lowest, highest;           ///< range of the first output
  float sample_period_s, longest;  ///< dt that it takes at most [s]
  unsigned pointer;
};
extern const CalledObserver called;

/// Arguments of the calls. The sizes exceed every observer's outputs and inputs.
extern float call_y[16], call_u[16], call_dt_s;

void call_step();
void call_step_dt();
void call_estimate();
void call_usable_outputs();  ///< calls the monitor before a step
void call_watch();           ///< calls the monitor after a step, with the last estimate
