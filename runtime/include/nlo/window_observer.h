// SPDX-License-Identifier: MIT
// The window observer: a learned map of the last measurements, what one would write without an observer.
//   z = [y_j(k), y_j(k - 1), ..., y_j(k - n + 1)] for each output j and each known input,   x_hat = T*(z)
// It forgets in n samples, whatever came before; it filters noise only as far as T* has learned to.
#pragma once

#include <cstdint>

#include "nlo/explicit_rk.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/latent.h"
#include "nlo/measurement.h"
#include "nlo/mlp.h"
#include "nlo/observer_state.h"
#include "nlo/sampled_observer.h"

namespace nlo {

/// The observer as a value. Generated headers define one `inline constexpr Model kModel`.
template <class Scalar_, int kNx_, int kNy_, int kSamples_, class InverseMap_, int kNu_ = 0,
          Hold kInputHold_ = Hold::kZeroOrder>
struct WindowModel {
  using Scalar = Scalar_;
  using InverseMap = InverseMap_;
  static constexpr int kNx = kNx_;
  static constexpr int kNy = kNy_;
  static constexpr int kSamples = kSamples_;  ///< n
  static constexpr int kNu = kNu_;
  static constexpr int kNf = 0;
  static constexpr int kNr = kNy + kNu;  ///< readings: outputs, then inputs
  static constexpr Hold kInputHold = kInputHold_;
  static constexpr int kNz = kNr * kSamples;
  static constexpr int kLongestGap = kMostPieces;
  static constexpr bool kHasSteadyState = false;
  static constexpr bool kMayDiverge = false;
  static_assert(kNx > 0 && kNy > 0 && kSamples > 0);
  static_assert(InverseMap::kIn == kNz && InverseMap::kOut == kNx, "T* maps (n_y + n_u) n readings to n_x");

  Scalar sample_period_s;
  std::uint16_t stale_after;          ///< this many held measurements in a row make the status kStale
  Hold hold;                          ///< y in a gap: kZeroOrder, or a ramp
  ReadingRange<Scalar, kNr> outputs;  ///< and of inputs, behind them
  Domain<Scalar, kNz> domain;
  InverseMap inverse_map;

  constexpr const Scalar (&initial_latent() const)[kNz] { return kEmpty; }

  /// The first measurement fills the window.
  template <Arithmetic = Arithmetic::kFast>
  constexpr void start(const Scalar (&y)[kNr], Scalar (&z)[kNz]) const {
    for (int j = 0; j < kNr; ++j) {
      for (int i = 0; i < kSamples; ++i) z[j * kSamples + i] = y[j];
    }
  }

  /// The window moves by as many samples as dt_s spans (0: one); those that a gap has left out lie on the hold.
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  constexpr void advance(Scalar (&z)[kNz], const Scalar (&y)[kNr], const Scalar (&y_next)[kNr], Scalar dt_s) const {
    const int samples = dt_s == Scalar(0) ? 1 : pieces_of(dt_s, sample_period_s);
    for (int s = 1; s <= samples; ++s) {
      Scalar now[kNr]{};
      between<kArithmetic>(hold, y, y_next, static_cast<Scalar>(s) / static_cast<Scalar>(samples), now);
      for (int j = 0; j < kNr; ++j) {
        Scalar* row = z + j * kSamples;
        for (int i = kSamples - 1; i > 0; --i) row[i] = row[i - 1];
        row[0] = s == samples ? y_next[j] : now[j];
      }
    }
  }

  /// With log2_sigma (kNx): see error_head.h.
  template <Arithmetic kArithmetic = Arithmetic::kFast, class... Log2Sigma>
  void estimate(const Scalar (&z)[kNz], const Scalar (&)[kNr], Scalar (&x_hat)[kNx], Log2Sigma*... log2_sigma) const {
    inverse_map.template evaluate<kArithmetic>(z, x_hat, log2_sigma...);
  }

 private:
  static constexpr Scalar kEmpty[kNz]{};
};

/// The observer of a WindowModel. Deterministic arithmetic is one more word, as for KklObserver.
template <class Model, Arithmetic kArithmetic = Arithmetic::kFast>
class WindowObserver : public SampledObserver<Model, kArithmetic> {
 public:
  using SampledObserver<Model, kArithmetic>::SampledObserver;
};
template <class Model>
WindowObserver(const Model&) -> WindowObserver<Model>;

}  // namespace nlo
