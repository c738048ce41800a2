// watched: a learned state observer (Kazantzis-Kravaris/Luenberger), generated. Do not edit this
// file. To make it again:
//   nlo export model.json -o watched.h
//
// Estimates position [m] from y [m], sampled every 0.02 s.
// Latent state: 2 (0 complex pairs), first_order hold. Inverse map T*: 2-4-1 tanh, reads z.
// Normalisation and features are folded into the layers.
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
//   kModel      168 bytes of constants (more where layers are padded to cache lines for SIMD)
//   Observer    20 bytes of RAM where pointers have 32 bits
//
// Use
//   #include "watched.h"
//   constinit static nlo::watched::Observer observer{nlo::watched::kModel};
//   constinit static nlo::watched::Monitor monitor{nlo::watched::kMonitor};
//
//   void on_timer() {  // every 0.02 s
//     const auto status = observer.step(monitor.usable_outputs(read_y(), observer));
//     if (status != nlo::StepStatus::kOk) note_fault(status);  // kClamped, kHeld: usable for a while
//     if (status >= nlo::StepStatus::kStale) return enter_safe_mode();  // also kOutOfRange
//     if (!observer.in_domain()) return enter_safe_mode();
//     const auto x_hat = observer.estimate();
//     if (monitor.watch(observer, x_hat) != nlo::Alarm::kNone) return enter_safe_mode();
//     use(x_hat[nlo::watched::State::position]);
//   }
#pragma once

#include <nlo/kkl_observer.h>
#include <nlo/monitor.h>

namespace nlo::watched {

/// Positions in a measurement and in an estimate.
struct Output {
  enum : int { y };
};
struct State {
  enum : int { position };
};

namespace weights {

// 4 x 2: one neuron per line, reads z.
inline constexpr Dense<float, 2, 4> kLayer1 = {
    .weights = {
      {0.232917f, 3.440228f},
      {1.6481663f, -0.7788087f},
      {-0.19503292f, 3.679755f},
      {1.3204453f, 0.32287326f},
    },
    .bias = {-0.5352224f, 0.5366941f, -0.48333663f, 0.20517758f},
};

// 1 x 4: one neuron per line, reads layer 1.
inline constexpr Dense<float, 4, 1> kLayer2 = {
    .weights = {
      {-0.14829469f, 0.09898687f, -0.21073124f, -1.0957534f},
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

// Detects that the observer is wrong. Its limits are set for 1 false alarm an hour, on 12 h of runs
// as in training.
using MonitorModel = nlo::MonitorModel<float, 1, 1, 2, 1, 2>;  // n_x, n_y, n_z, n_r, windows
using Monitor = nlo::Monitor<MonitorModel>;
inline constexpr MonitorModel kMonitor = {
    .prediction = {
      {-0.14380637f, 0.03279612f, -0.13070284f, 0.040032435f},
    },
    .offset = {0.033333335f},
    .per_deviation = {3.3333333f},
    .least_variance = {0.5f},
    .latent_mean = {0.048312977f, -0.06801792f},
    .per_latent_deviation = {0.5f, 2.0f},
    .gain = {0.18126924f, 0.048770577f},
    .mean_limit = {{0.5f, 0.5f}},
    .variance_limit = {{4.0f, 4.0f}},
    .correlation_limit = {{2.0f, 2.0f}},
    .latent_limit = {3.0f, 2.0f},
    .missing_limit = {0.4f},
    .gate_squared = 16.0f,
    .armed_after = 10,
    .most_equal = {30},
    .resting = {0.0f},
    .reference_sensor = {0},
    .rest_min = {-0.25f},
    .rest_max = {0.5f},
    .most_moved = {50.0f},
    .motion = {0.1f},
    .row = {
      {0.045635756f, 0.022554308f, -0.013457815f},
    },
    .row_offset = {0.02f},
    .per_row_deviation = {2.0f},
    .disagreement_limit = {3.0f},
};

}  // namespace nlo::watched
