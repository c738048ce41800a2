// SPDX-License-Identifier: MIT
// The observer whose calls seen.cpp counts. It is compiled separately, so that no call is inlined into the count.
#pragma once

/// The observer whose calls are counted, and its monitor if it has one. `state`: their bytes after the pointer to the
/// first model. `pointer`: the offset in these bytes of the pointer to the second model, or the end of the bytes.
struct CalledObserver {
  int outputs, inputs;
  unsigned char* state;
  unsigned bytes;
  float lowest, highest;           ///< range of the first output
  float sample_period_s, longest;  ///< sample period, and the longest dt that it accepts [s]
  unsigned pointer;
};
extern const CalledObserver called;

/// Arguments of the calls. They have room for the outputs and inputs of every observer.
extern float call_y[16], call_u[16], call_dt_s;

void call_step();
void call_step_dt();
void call_estimate();
void call_usable_outputs();  ///< calls the monitor before a step
void call_watch();           ///< calls the monitor after a step, with the last estimate
