// driven: a learned state observer (driven Kazantzis-Kravaris/Luenberger), generated. Do not edit
// this file. To make it again:
//   nlo export model.json -o driven.h
//
// Estimates x1, x2 from y1 [rad] and the inputs torque [N m], wind, sampled every 0.02 s.
// Latent state: 3 (1 complex pair), first_order hold. Inverse map T*: 4-12-2 tanh and a linear
// path, reads [z; y].
// Inputs act by phi(z) u = dT/dx g(x_hat) u, stepped at order 4; D and F are stepped exactly. u is
// a ramp between samples.
// Forward map T: 2-12-3 tanh and a linear path, reads x.
// Normalisation and features are folded into the layers.
//
// About the model
//   plant                         driven
//   seed                          3
//
// Readings
//   y1 [rad]                    used unchanged from -3 to 3, clamped beyond
//   torque [N m]                used unchanged
//   wind                        used unchanged
// While a reading is clamped, in_domain() is false.
// After 8 such samples in a row the status is out of range.
//
// Cost
//   step()      958 multiply-adds, 96 activations
//   estimate()  80 multiply-adds, 12 activations
//   kModel      1,016 bytes of constants (more where layers are padded to cache lines for SIMD)
//   Observer    36 bytes of RAM where pointers have 32 bits
//
// Use
//   #include "driven.h"
//   constinit static nlo::driven::Observer observer{nlo::driven::kModel};
//
//   void on_timer() {  // every 0.02 s
//     const auto status = observer.step({{read_y1()}}, {{read_torque(), read_wind()}});
//     if (status != nlo::StepStatus::kOk) note_fault(status);  // kClamped, kHeld: usable for a while
//     if (status >= nlo::StepStatus::kStale) return enter_safe_mode();  // also kOutOfRange
//     if (!observer.in_domain()) return enter_safe_mode();
//     const auto x_hat = observer.estimate();
//     use(x_hat[nlo::driven::State::x1]);
//   }
#pragma once

#include <nlo/driven_kkl_observer.h>

namespace nlo::driven {

/// Positions in a measurement, in an input and in an estimate.
struct Output {
  enum : int { y1 };
};
struct Input {
  enum : int { torque, wind };
};
struct State {
  enum : int { x1, x2 };
};

namespace weights {

// 12 x 4: one neuron per line, reads [z; y].
inline constexpr Dense<float, 4, 12> kLayer1 = {
    .weights = {
      {0.73874295f, 0.42576742f, 0.007412583f, 0.054051593f},
      {0.20909898f, -0.30836743f, -0.16239001f, 0.15213132f},
      {-0.48809305f, 0.46099657f, 0.4466033f, -0.26384127f},
      {0.3305096f, -0.5791657f, -0.23802437f, -0.3994529f},
      {-0.7534432f, -0.27728477f, 0.66487503f, -0.40744373f},
      {-0.7149155f, 0.63217676f, -0.54887867f, 0.36313736f},
      {-0.11055101f, -0.28725916f, 0.03278836f, -0.645249f},
      {0.9703161f, -0.69780666f, -0.39374858f, -0.3281119f},
      {-0.36269942f, 0.66598487f, 0.60426193f, 0.031791326f},
      {0.51101327f, 0.3130462f, 0.17887093f, -0.62381977f},
      {-0.2696571f, 0.43445823f, -0.10832169f, 0.13367221f},
      {0.73150355f, 0.41209826f, 0.09332768f, 0.012126769f},
    },
    .bias = {0.31670213f, -0.19461474f, -0.52137333f, -0.42134708f, 0.012705408f, -0.100022666f, -0.0145175485f, 0.040519457f, 0.2041397f, -0.22091675f, -0.05212534f, -0.29383716f},
};

// 2 x 12: one neuron per line, reads layer 1.
inline constexpr Dense<float, 12, 2> kLayer2 = {
    .weights = {
      {-0.12863371f, 0.38577104f, -0.07093353f, -0.37532616f, -0.12345419f, -0.06511318f, 0.06452784f, 0.35249588f, 0.31708032f, 0.099169455f, -0.39674047f, 0.13610539f},
      {-0.2876572f, -0.14200597f, 0.18278195f, 0.23789966f, -0.081022106f, 0.1465591f, -0.2422772f, 0.38113195f, 0.09222866f, 0.041200403f, -0.24926537f, 0.39790738f},
    },
    .bias = {-0.3447688f, 0.02586281f},
};

// 12 x 2: one neuron per line, reads x.
inline constexpr Dense<float, 2, 12> kForwardLayer1 = {
    .weights = {
      {-0.60564846f, 0.19540055f},
      {0.92542005f, -0.2559329f},
      {0.78855103f, -0.491151f},
      {-0.08287576f, -0.8872888f},
      {1.023605f, 0.2182331f},
      {-0.3243539f, 0.74578804f},
      {1.002099f, 0.2713973f},
      {0.02522038f, 0.7888456f},
      {0.011993672f, -0.28985217f},
      {0.26795855f, -0.15473638f},
      {-1.1650909f, 0.7755649f},
      {0.5577617f, 0.110994555f},
    },
    .bias = {-0.41526386f, -0.38067913f, -0.37145653f, 0.5475674f, 0.10651656f, -0.4234509f, -0.24558793f, -0.2788942f, -0.4335964f, -0.45062637f, -0.6296427f, -0.024659716f},
};

// 3 x 12: one neuron per line, reads layer 1.
inline constexpr Dense<float, 12, 3> kForwardLayer2 = {
    .weights = {
      {0.14280993f, 0.20622508f, -0.15919583f, -0.28548512f, 0.014801844f, -0.09989201f, 0.024539312f, -0.33441567f, -0.20401846f, -0.1627552f, -0.05771901f, -0.34253046f},
      {-0.2827006f, -0.069119364f, 0.23378466f, 0.03356021f, -0.0770645f, 0.044183653f, -0.17995726f, -0.18337241f, -0.20174523f, 0.09619627f, 0.28969547f, 0.3392159f},
      {-0.08777163f, 0.28833348f, -0.20105636f, 0.33499125f, -0.34835485f, 0.13341706f, 0.19111098f, -0.23184523f, 0.16611287f, 0.30376732f, -0.14452653f, 0.09271697f},
    },
    .bias = {-0.25739923f, -0.29107746f, -0.2162702f},
};

}  // namespace weights

using Network = decltype(make_mlp<Activation::kTanh>(weights::kLayer1, weights::kLayer2));
using ForwardNetwork = decltype(make_mlp<Activation::kTanh>(weights::kForwardLayer1, weights::kForwardLayer2));
using Model = DrivenKklModel<float, 2, 1, 3, 2, 1,  // n_x, n_y, n_z, n_u, complex pairs
                             LearnedMap<Network, LinearPath<float, 4, 2>>,
                             LearnedMap<ForwardNetwork, LinearPath<float, 2, 3>>>;
using Observer = DrivenKklObserver<Model>;

inline constexpr Model kModel = {
    .sample_period_s = 0.02f,
    .stale_after = 8,  // held measurements: the fastest mode's time constant
    .input_hold = Hold::kFirstOrder,
    .latent = {
        .hold = Hold::kFirstOrder,
        .eigenvalues = {-2.0f, 3.0f, -6.0f},  // 1/s
        .output_injection = {{2.0f}, {-3.0f}, {6.0f}},
        .step = {.a_minus_1 = {-0.04093946f, 0.057612784f, -0.11307956f},
                 .b0 = {{0.020621303f}, {-0.028409626f}, {0.055409256f}},
                 .b1 = {{0.02031816f}, {-0.029203158f}, {0.057670306f}}},
        .steady_gain = {{1.0f}, {0.0f}, {1.0f}},
        .initial = {0.0f, 0.0f, 0.0f},
        .starts_steady = true,
    },
    .forced = {  // coefficients of phi(z) u over one sample period, per stage
        .half = {.a_minus_1 = {-0.020242384f, 0.02940155f, -0.058235466f},
                 .b0 = {{0.0101609565f}, {-0.0146011645f}, {0.028826574f}},
                 .b1 = {{0.010081426f}, {-0.014800385f}, {0.029408893f}}},
        .weights = {.stage2 = {{0.009899186f, 0.00014800385f, 0.009705911f}},
                    .stage3_1 = {{-3.3738565e-05f, 4.9002316e-05f, -9.7053286e-05f}},
                    .stage3_2 = {{0.009932924f, 9.900153e-05f, 0.0098029645f}},
                    .stage4_1 = {{-0.00013648478f, 0.00019203809f, -0.00037684143f}},
                    .stage4_3 = {{0.01973012f, 0.00039202505f, 0.019223435f}},
                    .end_1 = {{0.0031971617f, 0.00019283388f, 0.0029541855f}},
                    .end_23 = {{0.0065314146f, 0.00019521675f, 0.006280691f}},
                    .end_4 = {{0.0033336463f, 7.957752e-07f, 0.003331027f}}},
    },
    .outputs = {.min = {-3.0f}, .max = {3.0f}, .wrap = {0.0f}},
    .domain = {.latent_min = {-8.0f, -8.0f, -8.0f},
               .latent_max = {8.0f, 8.0f, 8.0f}},
    .input_field = {.constant = {{0.07141652f, 0.61170954f}, {-0.09441793f, 0.119005635f}},
                    .linear = {{{-0.26232836f, -0.33981436f}, {-0.16147393f, -0.27280104f}}, {{0.14999281f, -0.33834484f}, {-0.1990877f, 0.2260714f}}}},
    .inverse_map = {
        .mlp = make_mlp<Activation::kTanh>(weights::kLayer1, weights::kLayer2),
        .linear_path = {.weights = {
            {0.4176559f, 0.07782097f, -0.15196744f, 0.1341779f},
            {0.06395006f, 0.3543259f, 0.022465259f, -0.060376972f},
          }},
    },
    .forward_map = {
        .mlp = make_mlp<Activation::kTanh>(weights::kForwardLayer1, weights::kForwardLayer2),
        .linear_path = {.weights = {
            {0.3612778f, -0.086782016f},
            {-0.17905004f, -0.080719665f},
            {0.068297714f, 0.0862061f},
          }},
    },
};

}  // namespace nlo::driven
