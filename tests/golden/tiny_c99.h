// tiny_c99: a learned state observer (Kazantzis-Kravaris/Luenberger) in C99, generated. Do not edit
// this file. To make it again:
//   nlo export model.json --target c99 --name tiny_c99 -o tiny_c99.h
//
// Estimates position [m] from y [m], sampled every 0.02 s.
// Latent state: 2 (0 complex pairs), first_order hold. Inverse map T*: 2-4-1 tanh, reads z.
// Normalisation and features are folded into the layers.
// The bits are the same on every IEEE 754 target, for every compiler and at every optimisation
// level, but not with -ffast-math or clang's -ffp-contract=fast.
//
// About the model
//   plant                         Van der Pol
//   seed                          1
//   norm N(0, 0.5)                0.17
//
// Readings
//   y [m]                       used unchanged from -3 to 3, clamped beyond
// While a reading is clamped, in_domain() is false.
// After 13 such samples in a row the status is out of range.
//
// An observer takes 16 bytes of RAM; the tables are constants. No heap, no library.
//
// Use
//   #include "tiny_c99.h"
//   static tiny_c99_observer observer;  // tiny_c99_init(&observer) at start
//
//   void on_timer(void) {  // every 0.02 s
//     const float y[tiny_c99_NY] = {read_y()};
//     float x_hat[tiny_c99_NX];
//     const tiny_c99_status status = tiny_c99_step(&observer, y);
//     if (status != tiny_c99_OK) note_fault(status);  // CLAMPED, HELD: usable for a while
//     if (status >= tiny_c99_STALE) { enter_safe_mode(); return; }  // also OUT_OF_RANGE
//     if (!tiny_c99_in_domain(&observer)) { enter_safe_mode(); return; }
//     tiny_c99_estimate(&observer, x_hat);
//     use(x_hat[tiny_c99_state_position]);
//   }

#ifndef tiny_c99_H
#define tiny_c99_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define tiny_c99_EXPORT 0xc877343a  // must equal that of tiny_c99.c

// Sizes: estimate, measurement, latent state.
enum { tiny_c99_NX = 1, tiny_c99_NY = 1, tiny_c99_NZ = 2 };

// Positions in a measurement and in an estimate.
enum { tiny_c99_output_y };
enum { tiny_c99_state_position };

// Result of a step; larger is worse. The latent state is finite after every step.
typedef enum {
  tiny_c99_OK,           // the measurement was used unchanged
  tiny_c99_CLAMPED,      // an output or input outside its declared range was clamped to it
  tiny_c99_HELD,         // an output was missing, not finite, or an angle out of range: its last good value was used
  tiny_c99_STALE,        // held 13 times in a row or more: do not trust the estimate
  tiny_c99_OUT_OF_RANGE, // outside its declared range 13 times in a row or more: do not trust the estimate
  tiny_c99_REJECTED,     // the time step was not positive, or longer than 1000 sample periods: nothing was done
  tiny_c99_RESET = 7     // a bit flip corrupted the state: the next measurement is the first
} tiny_c99_status;

// The whole state of an observer. A copy saves it.
typedef struct {
  float z[2];     // latent state
  float y[1];     // last good measurement; angles within their first turn
  uint16_t health[1]; // health of each channel; 0: used unchanged
  uint8_t status;  // status of the latest step
  uint8_t started; // 1 after the first measurement
} tiny_c99_observer;

// Makes an observer, or resets it: it waits for its first measurement. Call one of them before anything else.
void tiny_c99_init(tiny_c99_observer* observer);
void tiny_c99_reset(tiny_c99_observer* observer);

// Starts from the steady state of y. This shortens the transient if the plant is at rest, also after a gap.
tiny_c99_status tiny_c99_warm_start(tiny_c99_observer* observer, const float y[1]);

// Advances the observer by one sample period, with the measurement y at the end of it. The first measurement after a reset
// only starts the observer. A measurement that is not finite counts as missing. 6 multiply-adds.
tiny_c99_status tiny_c99_step(tiny_c99_observer* observer, const float y[1]);

// The same over dt_s seconds, for jitter and after missed samples. Some 60 operations per latent state.
// A step over more than 1.5 sample periods has the status of round(dt_s / period) - 1 missed samples (HELD or STALE).
// The measurement is used nevertheless.
tiny_c99_status tiny_c99_step_dt(tiny_c99_observer* observer, const float y[1], float dt_s);

// Advances the observer by one sample period without a measurement: the last good one is held.
tiny_c99_status tiny_c99_step_missed(tiny_c99_observer* observer);

// Computes x_hat. Each call takes 12 multiply-adds, 4 activations.
void tiny_c99_estimate(const tiny_c99_observer* observer, float x_hat[1]);

// Returns the status of the latest step, or RESET if a bit flip has corrupted the state since then.
tiny_c99_status tiny_c99_last_status(const tiny_c99_observer* observer);

// Returns the status of one channel: an output's position. The status of the step is the worst of all channels.
// REJECTED and RESET apply to every channel. REJECTED is also returned for a channel number out of range.
tiny_c99_status tiny_c99_status_of(const tiny_c99_observer* observer, int channel);

// Returns true if z is within the range of the training and no reading is clamped. Otherwise the estimate extrapolates.
bool tiny_c99_in_domain(const tiny_c99_observer* observer);

// Continues from a saved observer. Returns false and changes nothing if steps cannot lead to its state, because storage may
// have damaged it.
bool tiny_c99_restore(tiny_c99_observer* observer, const tiny_c99_observer* saved);

#ifdef __cplusplus
}
#endif

#endif
