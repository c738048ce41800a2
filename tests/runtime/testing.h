// SPDX-License-Identifier: MIT
// Helpers for the tests of the runtime: small observers as constants, built as in a generated header, and random
// numbers that are the same on each platform.
#pragma once

#include <nlo/kkl_observer.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <random>
#include <type_traits>

namespace nlo::testing {

inline constexpr double kPi = 3.14159265358979323846;

/// Compares all members bit for bit, except padding.
template <class State>
bool same_bits(const State& a, const State& b) {
  return std::memcmp(a.z, b.z, sizeof(a.z)) == 0 && std::memcmp(a.y, b.y, sizeof(a.y)) == 0 &&
         std::memcmp(a.health, b.health, sizeof(a.health)) == 0 && a.started == b.started && a.status == b.status;
}

/// Compares z and y bit for bit.
template <class State>
bool same_latent(const State& a, const State& b) {
  return std::memcmp(a.z, b.z, sizeof(a.z)) == 0 && std::memcmp(a.y, b.y, sizeof(a.y)) == 0;
}

/// Returns a uniform draw that does not depend on distributions of the standard library.
template <class Scalar>
Scalar uniform(std::mt19937& random, double low, double high) {
  return static_cast<Scalar>(low + (high - low) * (static_cast<double>(random()) / 4294967296.0));
}

/// Returns any float or double, including NaNs, infinities and subnormals.
template <class Scalar>
Scalar any_bits(std::mt19937& random) {
  if constexpr (sizeof(Scalar) == 4) {
    return std::bit_cast<Scalar>(static_cast<std::uint32_t>(random()));
  } else {
    return std::bit_cast<Scalar>(static_cast<std::uint64_t>(random()) << 32 | random());
  }
}

/// A batch whose memory a test can corrupt.
template <class Batch>
struct UpsetBatch : Batch {
  using Batch::Batch;
  void corrupt_z(int r, int plant, double value) { set(this->z_[r][plant], value); }
  void corrupt_y(int j, int plant, double value) { set(this->y_[j][plant], value); }

 private:
  template <class Scalar>
  static void set(Scalar& place, double value) {
    place = static_cast<Scalar>(value);
  }
};

/// Computes the fields that follow from D, F and the sample period: the step and S = -D^-1 F.
template <class Model>
constexpr void complete(Model& model) {
  using Scalar = typename Model::Scalar;
  auto& latent = model.latent;
  latent.step =
      discretise<Model::kPairs>(latent.hold, latent.eigenvalues, latent.output_injection, model.sample_period_s);
  for (int j = 0; j < Model::kNr; ++j) {
    for (int r = 0; r < 2 * Model::kPairs; r += 2) {  // -f / lambda
      const Scalar re = latent.eigenvalues[r], im = latent.eigenvalues[r + 1];
      const Scalar f_re = latent.output_injection[r][j], f_im = latent.output_injection[r + 1][j];
      latent.steady_gain[r][j] = -(f_re * re + f_im * im) / (re * re + im * im);
      latent.steady_gain[r + 1][j] = -(f_im * re - f_re * im) / (re * re + im * im);
    }
    for (int r = 2 * Model::kPairs; r < Model::kNz; ++r) {
      latent.steady_gain[r][j] = -latent.output_injection[r][j] / latent.eigenvalues[r];
    }
  }
}

/// T* = identity on z, so estimates show the latent state.
template <class Scalar, int kN>
constexpr auto identity_map() {
  Dense<Scalar, kN, kN> layer{};
  for (int i = 0; i < kN; ++i) layer.weights[i][i] = Scalar(1);
  return LearnedMap<Mlp<Activation::kTanh, PackedDense<Scalar, kN, kN>>>{make_mlp<Activation::kTanh>(layer), {}};
}

/// One output with the range [-10, 10], a complex pair and a real mode, 50 Hz.
template <class Scalar>
using PairModel = KklModel<Scalar, 3, 1, 3, 1, decltype(identity_map<Scalar, 3>())>;

template <class Scalar>
constexpr PairModel<Scalar> pair_model(Hold hold, bool starts_steady = false) {
  PairModel<Scalar> model{};
  model.sample_period_s = Scalar(0.02);
  model.stale_after = 3;
  model.latent.hold = hold;
  model.latent.eigenvalues[0] = Scalar(-0.8);
  model.latent.eigenvalues[1] = Scalar(0.9);
  model.latent.eigenvalues[2] = Scalar(-2);
  model.latent.output_injection[0][0] = Scalar(1);
  model.latent.output_injection[1][0] = Scalar(0.5);
  model.latent.output_injection[2][0] = Scalar(1);
  model.latent.initial[0] = Scalar(0.25);
  model.latent.initial[2] = Scalar(-0.5);
  model.latent.starts_steady = starts_steady;
  model.outputs.min[0] = Scalar(-10);
  model.outputs.max[0] = Scalar(10);
  for (int r = 0; r < 3; ++r) {
    model.domain.latent_min[r] = Scalar(-5);
    model.domain.latent_max[r] = Scalar(5);
  }
  model.inverse_map = identity_map<Scalar, 3>();
  complete(model);
  return model;
}

/// An angle [rad] and another output. T* reads z - S y of the angle's modes, so whole turns have no effect, and the
/// mode of the other output: z0 - angle, (z1, z2) - S angle, z3.
template <class Scalar>
using AngleModel =
    KklModel<Scalar, 4, 2, 4, 1, LearnedMap<Mlp<Activation::kTanh, PackedDense<Scalar, 6, 4>>, NoLinearPath>>;

template <class Scalar>
constexpr AngleModel<Scalar> angle_model(double low = -kPi, double high = kPi, bool starts_steady = true) {
  AngleModel<Scalar> model{};
  model.sample_period_s = Scalar(0.004);
  model.stale_after = 3;
  model.latent.hold = Hold::kFirstOrder;
  model.latent.eigenvalues[0] = Scalar(-30);
  model.latent.eigenvalues[1] = Scalar(40);
  model.latent.eigenvalues[2] = Scalar(-50);
  model.latent.eigenvalues[3] = Scalar(-20);
  model.latent.output_injection[0][0] = Scalar(30);  // unit DC gain: f = -lambda
  model.latent.output_injection[1][0] = Scalar(-40);
  model.latent.output_injection[2][0] = Scalar(50);
  model.latent.output_injection[3][1] = Scalar(20);
  model.latent.starts_steady = starts_steady;
  model.outputs.min[0] = static_cast<Scalar>(low);
  model.outputs.max[0] = static_cast<Scalar>(high);
  model.outputs.wrap[0] = static_cast<Scalar>(2 * kPi);
  model.outputs.min[1] = Scalar(-1);
  model.outputs.max[1] = Scalar(1);
  complete(model);
  Dense<Scalar, 6, 4> relative{};
  for (int r = 0; r < 4; ++r) {
    model.domain.latent_min[r] = Scalar(-2);
    model.domain.latent_max[r] = Scalar(2);
    relative.weights[r][r] = Scalar(1);
    relative.weights[r][4] = -model.latent.steady_gain[r][0];
  }
  model.inverse_map.mlp = make_mlp<Activation::kTanh>(relative);
  return model;
}

}  // namespace nlo::testing
