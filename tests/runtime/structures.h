// SPDX-License-Identifier: MIT
// Small observers of the other structures for the tests of the runtime, in any scalar: a Luenberger-like and a general
// one with the same linear error dynamics, a driven KKL one. With zero networks they are linear.
#pragma once

#include <nlo/carried_observer.h>
#include <nlo/driven_kkl_observer.h>
#include <nlo/gated_observer.h>
#include <nlo/general_observer.h>
#include <nlo/luenberger_observer.h>
#include <nlo/prior_observer.h>

#include "tests/runtime/testing.h"

namespace nlo::testing {

/// Weights between -scale and scale that look random and are the same on each platform.
template <class Scalar, int kIn, int kOut>
constexpr Dense<Scalar, kIn, kOut> mixed_dense(double scale, int phase) {
  Dense<Scalar, kIn, kOut> layer{};
  for (int o = 0; o < kOut; ++o) {
    for (int i = 0; i < kIn; ++i) {
      const int step = (7 * o + 11 * i + 3 * phase + o * i) % 17;
      layer.weights[o][i] = static_cast<Scalar>(scale * (step - 8) / 8.0);
    }
    layer.bias[o] = static_cast<Scalar>(scale * ((5 * o + phase) % 7 - 3) / 10.0);
  }
  return layer;
}

template <class Scalar, int kIn, int kOut>
constexpr auto mixed_mlp(double scale, int phase) {
  return make_mlp<Activation::kTanh>(mixed_dense<Scalar, kIn, 8>(0.8, phase),
                                     mixed_dense<Scalar, 8, kOut>(scale, phase + 1));
}
template <class Scalar, int kIn, int kOut>
using MixedMlp = decltype(mixed_mlp<Scalar, kIn, kOut>(1.0, 1));

/// One output with the range +-10, 50 Hz, stale after three held measurements.
template <class Model>
constexpr void set_sampling(Model& model) {
  using Scalar = typename Model::Scalar;
  model.sample_period_s = Scalar(0.02);
  model.stale_after = 3;
  model.outputs.min[0] = Scalar(-10);
  model.outputs.max[0] = Scalar(10);
  for (int r = 0; r < Model::kNz; ++r) {
    model.domain.latent_min[r] = Scalar(-5);
    model.domain.latent_max[r] = Scalar(5);
  }
}

// The linear part of the next two observers: x_hat' = A_e x_hat + G y.
inline constexpr double kErrorMatrix[2][2] = {{-3.0, 1.0}, {-6.0, -0.3}};
inline constexpr double kGain[2] = {3.0, 2.0};
inline constexpr double kInitial[2] = {0.5, -0.25};

template <class Scalar>
using PendulumModel = LuenbergerModel<Scalar, 2, 1, LearnedMap<MixedMlp<Scalar, 2, 2>>>;

template <class Scalar>
constexpr PendulumModel<Scalar> luenberger_model(double network_scale = 0.3) {
  PendulumModel<Scalar> model{};
  set_sampling(model);
  model.hold = Hold::kFirstOrder;
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < 2; ++k) model.error_matrix[i][k] = Scalar(kErrorMatrix[i][k]);
    model.gain[i][0] = Scalar(kGain[i]);
    model.initial[i] = Scalar(kInitial[i]);
  }
  model.nonlinearity.mlp = mixed_mlp<Scalar, 2, 2>(network_scale, 1);
  return model;
}

template <class Scalar>
using GeneralTestModel = GeneralModel<Scalar, 2, 1, 2, LearnedMap<MixedMlp<Scalar, 3, 2>, LinearPath<Scalar, 3, 2>>,
                                      decltype(identity_map<Scalar, 2>())>;

template <class Scalar>
constexpr GeneralTestModel<Scalar> general_model(double network_scale = 0.3) {
  GeneralTestModel<Scalar> model{};
  set_sampling(model);
  model.hold = Hold::kFirstOrder;
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < 2; ++k) model.dynamics.linear_path.weights[i][k] = Scalar(kErrorMatrix[i][k]);
    model.dynamics.linear_path.weights[i][2] = Scalar(kGain[i]);
    model.initial[i] = Scalar(kInitial[i]);
  }
  model.dynamics.mlp = mixed_mlp<Scalar, 3, 2>(network_scale, 2);
  model.inverse_map = identity_map<Scalar, 2>();
  return model;
}

/// pair_model (a pair and a real mode, one output) with two inputs, bilinear; T* reads [z; y].
template <class Scalar>
using DrivenTestModel = DrivenKklModel<Scalar, 2, 1, 3, 2, 1, LearnedMap<MixedMlp<Scalar, 4, 2>>,
                                       LearnedMap<MixedMlp<Scalar, 2, 3>, LinearPath<Scalar, 2, 3>>>;

/// The plain KKL observer with the same D, F and T*.
template <class Scalar>
using UndrivenTestModel = KklModel<Scalar, 2, 1, 3, 1, LearnedMap<MixedMlp<Scalar, 4, 2>>>;

template <class Scalar>
constexpr DrivenTestModel<Scalar> driven_model(Hold hold, Hold input_hold) {
  DrivenTestModel<Scalar> model{};
  set_sampling(model);
  model.latent = pair_model<Scalar>(hold, true).latent;
  model.input_hold = input_hold;
  model.forced = forced_step<1>(model.latent.exact_hold(), model.latent.eigenvalues, model.latent.output_injection,
                                model.sample_period_s);
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < 2; ++k) {
      model.input_field.constant[i][k] = Scalar(0.4 + 0.3 * i - 0.2 * k);
      for (int l = 0; l < 2; ++l) model.input_field.linear[i][k][l] = Scalar(0.1 * (i + 2 * k - 3 * l));
    }
  }
  model.inverse_map.mlp = mixed_mlp<Scalar, 4, 2>(1.0, 3);
  model.forward_map.mlp = mixed_mlp<Scalar, 2, 3>(0.8, 4);
  for (int r = 0; r < 3; ++r) model.forward_map.linear_path.weights[r][r % 2] = Scalar(0.5);
  return model;
}

template <class Scalar>
constexpr UndrivenTestModel<Scalar> undriven_model(Hold hold) {
  UndrivenTestModel<Scalar> model{};
  set_sampling(model);
  model.latent = pair_model<Scalar>(hold, true).latent;
  model.inverse_map.mlp = mixed_mlp<Scalar, 4, 2>(1.0, 3);
  return model;
}

/// Five gated units, one output; T* reads [z; y].
template <class Scalar>
using GatedTestModel =
    GatedModel<Scalar, 2, 1, 5, LearnedMap<Mlp<Activation::kTanh, PackedDense<Scalar, 6, 10>>>,
               LearnedMap<Mlp<Activation::kTanh, PackedDense<Scalar, 6, 5>>>, LearnedMap<MixedMlp<Scalar, 6, 2>>>;

template <class Scalar>
constexpr GatedTestModel<Scalar> gated_model(double network_scale = 1.0) {
  GatedTestModel<Scalar> model{};
  set_sampling(model);
  auto gates = mixed_dense<Scalar, 6, 10>(network_scale, 6);
  for (int r = 0; r < 5; ++r) gates.bias[r] = Scalar(-0.4 * r);  // half of the distance in 1 to 4 periods
  auto candidate = mixed_dense<Scalar, 6, 5>(network_scale, 7);
  for (int r = 0; r < 5; ++r) {
    candidate.bias[r] = Scalar(0.5 - 0.3 * r);
    model.initial[r] = Scalar(0.2 * r - 0.5);
  }
  model.gates.mlp = make_mlp<Activation::kTanh>(gates);
  model.candidate.mlp = make_mlp<Activation::kTanh>(candidate);
  model.inverse_map.mlp = mixed_mlp<Scalar, 6, 2>(1.0, 8);
  return model;
}

/// One measured and one estimated vector; a pair and a real mode for each component.
template <class Scalar, bool kReadsOutput = true, bool kUnitLength = true>
using CarriedTestModel = CarriedModel<Scalar, 3, 3, 3, 1, kReadsOutput, kUnitLength>;

template <class Scalar, bool kReadsOutput = true, bool kUnitLength = true>
constexpr CarriedTestModel<Scalar, kReadsOutput, kUnitLength> carried_model(Hold hold = Hold::kFirstOrder) {
  CarriedTestModel<Scalar, kReadsOutput, kUnitLength> model{};
  set_sampling(model);
  for (int j = 0; j < 6; ++j) {
    model.outputs.min[j] = Scalar(-10);
    model.outputs.max[j] = Scalar(10);
  }
  model.latent = pair_model<Scalar>(hold, true).latent;
  for (int f = 0; f < model.kFeatures; ++f) model.weights[0][f] = Scalar(0.7 - 0.4 * f);
  return model;
}

/// A Van der Pol oscillator, y = x1.
template <class Scalar>
struct OscillatorEquations {
  static constexpr void derivative(const Scalar (&x)[5], const Scalar*, Scalar (&dx)[5]) {
    const Scalar grows = Scalar(1) - rounded<Scalar>(x[0] * x[0]);
    const Scalar turns = rounded<Scalar>(rounded<Scalar>(Scalar(-2) * x[0]) * x[1]) - Scalar(1);
    dx[0] = x[1];
    dx[1] = rounded<Scalar>(grows * x[1]) - x[0];
    dx[2] = Scalar(2) * x[3];
    dx[3] = x[4] + rounded<Scalar>(turns * x[2]) + rounded<Scalar>(grows * x[3]);
    dx[4] = Scalar(2) * (rounded<Scalar>(turns * x[3]) + rounded<Scalar>(grows * x[4]));
  }
  static constexpr void output(const Scalar* x, Scalar (&y)[3]) {
    y[0] = x[0];
    y[1] = Scalar(1);
    y[2] = Scalar(0);
  }
};

/// Four units; w has two squashed innovations, y and two states.
template <class Scalar, class Equations = OscillatorEquations<Scalar>>
using PriorTestModel =
    PriorModel<Scalar, 2, 1, 4, Equations, LearnedMap<Mlp<Activation::kTanh, PackedDense<Scalar, 9, 8>>>,
               LearnedMap<Mlp<Activation::kTanh, PackedDense<Scalar, 9, 4>>>,
               LearnedMap<Mlp<Activation::kTanh, PackedDense<Scalar, 9, 7>>>, LearnedMap<MixedMlp<Scalar, 9, 2>>>;

template <class Scalar, class Equations = OscillatorEquations<Scalar>>
constexpr PriorTestModel<Scalar, Equations> prior_model() {
  PriorTestModel<Scalar, Equations> model{};
  set_sampling(model);
  for (int i = 0; i < 5; ++i) {
    model.state_min[i] = i == 2 || i == 4 ? Scalar(1e-6) : Scalar(-3);
    model.state_max[i] = Scalar(3.5);
  }
  model.initial[6] = model.initial[8] = Scalar(1);
  model.fine[0] = Scalar(0.1);
  model.coarse[0] = Scalar(2);
  model.state_noise[0] = model.state_noise[1] = Scalar(0.01);
  model.output_noise[0] = Scalar(0.1);
  auto gates = mixed_dense<Scalar, 9, 8>(1.0, 6);
  for (int r = 0; r < 4; ++r) gates.bias[r] = Scalar(-0.4 * r);
  model.gates.mlp = make_mlp<Activation::kTanh>(gates);
  model.candidate.mlp = make_mlp<Activation::kTanh>(mixed_dense<Scalar, 9, 4>(1.0, 7));
  auto correction = mixed_dense<Scalar, 9, 7>(0.1, 8);
  correction.bias[0] =
      Scalar(0.5);  // K corrects each x towards the measurement: without it, an oscillator would keep its phase
  correction.bias[1] = Scalar(0.3);
  model.correction.mlp = make_mlp<Activation::kTanh>(correction);
  model.inverse_map.mlp = mixed_mlp<Scalar, 9, 2>(1.0, 9);
  return model;
}

/// prior_model() without units: an extended Kalman filter. T* passes on x.
template <class Scalar>
using FilterTestModel = FilterModel<Scalar, 2, 1, OscillatorEquations<Scalar>,
                                    LearnedMap<Mlp<Activation::kTanh, PackedDense<Scalar, 5, 2>>>>;

template <class Scalar>
constexpr FilterTestModel<Scalar> filter_model() {
  const auto prior = prior_model<Scalar>();
  FilterTestModel<Scalar> model{};
  set_sampling(model);
  for (int i = 0; i < 5; ++i) {
    model.state_min[i] = prior.state_min[i];
    model.state_max[i] = prior.state_max[i];
    model.initial[i] = prior.initial[4 + i];
  }
  for (int i = 0; i < 2; ++i) model.state_noise[i] = prior.state_noise[i];
  model.output_noise[0] = prior.output_noise[0];
  auto map = mixed_dense<Scalar, 5, 2>(0.0, 1);
  for (int i = 0; i < 2; ++i) map.weights[i][i] = Scalar(1);
  model.inverse_map.mlp = make_mlp<Activation::kTanh>(map);
  return model;
}

/// One observer of each structure, and a filter.
template <class Scalar, class Check>
void each_structure(const Check& check) {
  static const auto kkl = undriven_model<Scalar>(Hold::kFirstOrder);
  static const auto luenberger = luenberger_model<Scalar>();
  static const auto general = general_model<Scalar>();
  static const auto driven = driven_model<Scalar>(Hold::kFirstOrder, Hold::kFirstOrder);
  static const auto gated = gated_model<Scalar>();
  static const auto carried = carried_model<Scalar>();
  static const auto prior = prior_model<Scalar>();
  static const auto filter = filter_model<Scalar>();
  const auto with = [&check](auto observer) { check(observer); };
  with(KklObserver(kkl));
  with(LuenbergerObserver(luenberger));
  with(GeneralObserver(general));
  with(DrivenKklObserver(driven));
  with(GatedObserver(gated));
  with(CarriedObserver(carried));
  with(PriorObserver(prior));
  with(PriorObserver(filter));
}

}  // namespace nlo::testing
