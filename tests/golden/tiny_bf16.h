// tiny: a learned state observer (Kazantzis-Kravaris/Luenberger), generated. Do not edit; make it
// again by
//   nlo export model.json --weights bf16 -o tiny.h
//
// Estimates position [m] from y [m], sampled every 0.02 s.
// Latent state: 2 (0 complex pairs), first_order hold. Inverse map T*: 2-4-1 tanh, reads z.
// Normalisation and features are folded into the layers.
//
// Weights of layers are in bf16, 2 bytes each; the arithmetic and all else is float.
// What this arithmetic costs, over
// 10,777 samples in its domain, of synthetic tones, for want of recorded flights
// (largest error, 99.9 % of samples within, rms; largest outside of the domain):
//   position [m]                2.0e-03, 1.9e-03, 9.9e-04; 1.8e-03
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
//   kModel      144 bytes of constants (more where layers are padded to cache lines for SIMD)
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
#include <nlo/kernels/weight.h>

namespace nlo::tiny {

/// Positions in a measurement and in an estimate.
struct Output {
  enum : int { y };
};
struct State {
  enum : int { position };
};

namespace weights {

// 4 x 2: one neuron per line, reads z.
inline constexpr Dense<Bfloat16, 2, 4> kLayer1 = {
    .weights = {
      {0.23339844f, 3.4375f},
      {1.6484375f, -0.77734375f},
      {-0.1953125f, 3.6875f},
      {1.3203125f, 0.32226562f},
    },
    .bias = {-0.5352224f, 0.5366941f, -0.48333663f, 0.20517758f},
};

// 1 x 4: one neuron per line, reads layer 1.
inline constexpr Dense<Bfloat16, 4, 1> kLayer2 = {
    .weights = {
      {-0.1484375f, 0.099121094f, -0.2109375f, -1.09375f},
    },
    .bias = {0.5261358f},
};

}  // namespace weights

using Network = decltype(make_mlp<Activation::kTanh>(weights::kLayer1, weights::kLayer2));
using Model = KklModel<float, 1, 1, 2, 0, LearnedMap<Network>>;  // n_x, n_y, n_z, complex pairs
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
        .mlp = make_mlp<Activation::kTanh>(weights::kLayer1, weights::kLayer2),
    },
};

}  // namespace nlo::tiny
