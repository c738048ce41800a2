// tiny: a learned state observer (Kazantzis-Kravaris/Luenberger), generated. Do not edit; make it
// again by
//   nlo export model.json --scalar int16 -o tiny.h
//
// Estimates position [m] from y [m], sampled every 0.02 s.
// Latent state: 2 (0 complex pairs), first_order hold. Inverse map T*: 2-4-1 tanh, reads z.
// Normalisation and features are folded into the layers.
//
// T* is in int16: weights of 16 bits, sums of 32 bits that cannot overflow, tanh by a table. All
// else is float.
// Where z leaves its domain, T* is that of the nearest point in it. What this arithmetic costs,
// over
// 10,777 samples in its domain, of synthetic tones, for want of recorded flights
// (largest error, 99.9 % of samples within, rms; largest outside of the domain):
//   position [m]                1.6e-04, 1.4e-04, 5.0e-05; 1.4e-04
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
// Cost
//   step()      6 multiply-adds
//   estimate()  12 multiply-adds, 4 activations
//   kModel      200 bytes of constants
//   Observer    20 bytes of RAM where pointers have 32 bits
//
// Use
//   #include "tiny.h"
//   constinit static nlo::tiny::Observer observer{nlo::tiny::kModel};
//
//   void on_timer() {  // every 0.02 s
//     const auto status = observer.step(read_y());
//     if (status != nlo::StepStatus::kOk) note_fault(status);  // kClamped, kHeld: usable for a while
//     if (status >= nlo::StepStatus::kStale) return enter_safe_mode();  // also kOutOfRange
//     if (!observer.in_domain()) return enter_safe_mode();
//     const auto x_hat = observer.estimate();
//     use(x_hat[nlo::tiny::State::position]);
//   }
#pragma once

#include <nlo/kkl_observer.h>
#include <nlo/quantised_map.h>

namespace nlo::tiny {

/// Positions in a measurement and in an estimate.
struct Output {
  enum : int { y };
};
struct State {
  enum : int { position };
};

namespace weights {

// QuantisedDense<inputs, neurons, shift> reads integers up to +-32767; sum / 2^shift is the argument of tanh, in Q16.

// 4 x 2: one neuron per line, reads z.
inline constexpr QuantisedDense<2, 4, 11> kLayer1 = {
    .weights = {
      {3816, 14092},
      {27004, -3190},
      {-3196, 15073},
      {21635, 1323},
    },
    .bias = {-71835312, 72034888, -64871319, 27539492},
};

// 1 x 4: one neuron per line, reads layer 1.
inline constexpr QuantisedDense<4, 1, 1> kLayer2 = {
    .weights = {
      {-4435, 2960, -6302, -32767},
    },
    .bias = {515515022},
};

}  // namespace weights

using Network = decltype(make_quantised_mlp<Activation::kTanh>(weights::kLayer1, weights::kLayer2));
using Model = KklModel<float, 1, 1, 2, 0, QuantisedMap<Network>>;  // n_x, n_y, n_z, complex pairs
using Observer = KklObserver<Model>;

inline constexpr Model kModel = {
    .sample_period_s = 0.02f,
    .stale_after = 13,  // held measurements: the fastest mode's time constant
    .latent = {
        .hold = Hold::kFirstOrder,
        .eigenvalues = {-1.0f, -4.0f},  // 1/s
        .output_injection = {{1.0f}, {1.0f}},
        .step = {.a_minus_1 = {-0.019801326f, -0.07688365f},
                 .b0 = {{0.009867662f}, {0.009482331f}},
                 .b1 = {{0.009933665f}, {0.009738582f}}},
        .steady_gain = {{1.0f}, {0.25f}},
        .initial = {0.0f, 0.0f},
        .starts_steady = false,
    },
    .outputs = {.min = {-3.0f}, .max = {3.0f}, .wrap = {0.0f}},
    .domain = {.latent_min = {-4.0f, -1.0f},
               .latent_max = {4.0f, 1.0f}},
    .inverse_map = {
        .centre = {0.0f, 0.0f},
        .gain = {8191.75f, 32767.0f},  // to +-32767
        .mlp = make_quantised_mlp<Activation::kTanh>(weights::kLayer1, weights::kLayer2),
        .scale = {1.0205622e-09f},
    },
};

}  // namespace nlo::tiny
