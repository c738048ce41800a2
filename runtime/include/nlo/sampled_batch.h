// SPDX-License-Identifier: MIT
// Many plants with one model, stepped together: fleets, hypotheses, the particles of a filter. State and values are
// structures of arrays, so that every weight is loaded once for many plants. A batch is limited by the multiply-add
// units, a single observer by the cache. KklBatch (kkl_batch.h) and GatedBatch (gated_batch.h) advance z.
//
//   static nlo::KklBatch<decltype(kModel), 32> fleet{kModel};
//   float y[1][32], x_hat[2][32];
//   if (fleet.step(y) != nlo::StepStatus::kOk) ...   // the worst status; status(plant) is that of one plant
//   fleet.estimate(x_hat);
//
// Each plant behaves as with its own observer, faults included. save() and restore() move the state of one plant. As in
// an observer there are no heap, no exceptions and no libm. A block with a fault, a first measurement or a reading that
// leaves its first turn is stepped plant by plant.
#pragma once

#include <cstdint>

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/batch.h"
#include "nlo/kernels/simd.h"
#include "nlo/kkl_observer.h"
#include "nlo/mlp_batch.h"
#include "nlo/sampled_observer.h"
#include "nlo/saturation.h"

namespace nlo::inline NLO_ISA::kernels {

namespace native {
using namespace nlo::simd;
using nlo::advance;
#define NLO_CODE NLO_INLINE
#include "nlo/kernels/per_isa/plants.inc"
#undef NLO_CODE
}  // namespace native

#if defined(NLO_DISPATCHES)
namespace x86 {

namespace avx2 {
#define NLO_CODE NLO_CODE_AVX2
#include "nlo/kernels/per_isa/recurrence.inc"
// plants.inc uses recurrence.inc. This comment keeps the formatter from sorting the two.
#include "nlo/kernels/per_isa/plants.inc"
#undef NLO_CODE
}  // namespace avx2

namespace avx512 {
#define NLO_CODE NLO_CODE_AVX512
#include "nlo/kernels/per_isa/recurrence.inc"
// As above.
#include "nlo/kernels/per_isa/plants.inc"
#undef NLO_CODE
}  // namespace avx512

}  // namespace x86
#endif

}  // namespace nlo::inline NLO_ISA::kernels

namespace nlo::inline NLO_ISA {

/// Batch has
///   advance_block<kTogether>(y, first)   advances z and y of kTogether plants from `first` on by one sample period.
///                                        Returns false and does nothing if a plant needs its observer for this
template <class Batch, class Model_, int kPlants_, Arithmetic kArithmetic>
class SampledBatch {
 public:
  using Model = Model_;
  using Scalar = typename Model::Scalar;
  using Observer = SampledObserver<Model, kArithmetic>;
  using State = typename Observer::State;
  using Latent = typename Observer::Latent;
  static constexpr int kPlants = kPlants_;
  static constexpr int kNx = Model::kNx;
  static constexpr int kNy = Model::kNy;
  static constexpr int kNz = Model::kNz;
  static constexpr int kNu = Model::kNu;
  static_assert(kPlants > 0);
  static_assert(Observer::kMeasured == kNy, "a batch takes all outputs: step models that compute some one by one");

  /// The model must outlive the batch; generated models are constants.
  constexpr explicit SampledBatch(const Model& model) : model_(&model) { reset(); }
  explicit SampledBatch(const Model&&) = delete;

  constexpr void reset() {
    const State fresh = Observer(*model_).save();
    for (int n = 0; n < kPadded; ++n) put(n, fresh);
  }

  /// Advances every plant by one sample period with its measurement y[j][plant] at the end. Returns the worst status.
  [[nodiscard]] StepStatus step(const Scalar (&y)[kNy][kPlants]) requires(kNu == 0) { return step_rows(rows<kNy>(y)); }

  /// The same with known inputs u[i][plant]. With the zero-order hold they have acted since the last sample.
  [[nodiscard]] StepStatus step(const Scalar (&y)[kNy][kPlants],
                                const Scalar (&u)[kNu == 0 ? 1 : kNu][kPlants]) requires(kNu > 0) {
    Rows all = rows<kNy>(y);
    for (int i = 0; i < kNu; ++i) all[kNy + i] = u[i];
    return step_rows(all);
  }

  /// Computes x_hat[i][plant] for every plant.
  void estimate(Scalar (&x_hat)[kNx][kPlants]) const {
    kernels::for_batch_block<Scalar>([&](auto block) {
      for (int first = 0; first < kPlants; first += block) estimate_block<block>(x_hat, first);
    });
  }

  /// Returns the status of the latest step of a plant.
  [[nodiscard]] constexpr StepStatus status(int plant) const { return status_[plant]; }

  /// Returns the status of one of its channels, see ObserverCore::status(channel).
  [[nodiscard]] constexpr StepStatus status(int plant, int channel) const {
    Observer observer(*model_);
    return observer.restore(save(plant)) ? observer.status(channel) : StepStatus::kReset;
  }

  [[nodiscard]] constexpr Latent latent(int plant) const {
    Latent z{};
    for (int r = 0; r < kNz; ++r) z[r] = z_[r][plant];
    return z;
  }

  /// Returns in_domain() of the observer of a plant.
  [[nodiscard]] constexpr bool in_domain(int plant) const {
    Observer observer(*model_);
    return observer.restore(save(plant)) && observer.in_domain();
  }

  [[nodiscard]] constexpr State save(int plant) const {
    State state{};
    for (int r = 0; r < kNz; ++r) state.z[r] = z_[r][plant];
    for (int j = 0; j < kNr; ++j) state.y[j] = y_[j][plant];
    for (int j = 0; j < kNr; ++j) state.health[j] = health_[j][plant];
    state.status = status_[plant];
    state.started = started_[plant];
    return state;
  }

  /// Continues a plant from a saved state. Returns false and changes nothing if steps cannot lead to that state.
  [[nodiscard]] constexpr bool restore(int plant, const State& saved) {
    Observer observer(*model_);
    if (!observer.restore(saved)) return false;
    put(plant, saved);
    return true;
  }

 protected:
  static constexpr int kPadded = kernels::rounded_up(kPlants, kernels::kMostBatchBlock<Scalar>);
  static constexpr int kAlignment = kernels::kHasVectors ? 64 : alignof(Scalar);

  static constexpr int kNr = Model::kNr;
  static constexpr int kGiven = kNy + kNu;     ///< readings that step() takes
  using Rows = Vector<const Scalar*, kGiven>;  ///< outputs, then inputs; each has kPlants entries

  static constexpr bool kSaturates = [] {
    if constexpr (requires { Model::kSaturation; }) return Model::kSaturation != Saturation::kNone;
    return false;
  }();

  template <int kCount>
  static Rows rows(const Scalar (&y)[kCount][kPlants]) {
    Rows all{};
    for (int j = 0; j < kCount; ++j) all[j] = y[j];
    return all;
  }

  const Model* model_;
  alignas(kAlignment) Scalar z_[kNz][kPadded];
  alignas(kAlignment) Scalar y_[kNr][kPadded];

 private:
  StepStatus step_rows(const Rows& y) {
    StepStatus worst = StepStatus::kOk;
    kernels::for_batch_block<Scalar>([&](auto block) {
      for (int first = 0; first < kPadded; first += block) {
        if constexpr (kPlants >= block) {
          if (first + block <= kPlants && step_block<block>(y, first)) continue;
        }
        for (int n = first; n < first + block && n < kPlants; ++n) {
          const StepStatus status = step_one(y, n);
          if (status > worst) worst = status;
        }
      }
    });
    return worst;
  }

  constexpr void put(int n, const State& state) {
    for (int r = 0; r < kNz; ++r) z_[r][n] = state.z[r];
    for (int j = 0; j < kNr; ++j) y_[j][n] = state.y[j];
    for (int j = 0; j < kNr; ++j) health_[j][n] = state.health[j];
    status_[n] = state.status;
    started_[n] = state.started;
  }

  StepStatus step_one(const Rows& y, int n) {
    Observer observer(*model_);
    if (!observer.restore(save(n))) {  // a bit flip corrupted the state
      State fresh = observer.save();
      fresh.status = StepStatus::kReset;
      put(n, fresh);
      return StepStatus::kReset;
    }
    typename Observer::Output measured{};
    for (int j = 0; j < kNy; ++j) measured[j] = y[j][n];
    const StepStatus status = [&] {
      if constexpr (kNu == 0) {
        return observer.step(measured);
      } else {
        typename Observer::Input input{};
        for (int i = 0; i < kNu; ++i) input[i] = y[kNy + i][n];
        return observer.step(measured, input);
      }
    }();
    put(n, observer.save());
    return status;
  }

  /// Steps a whole block if all its plants have started, all readings can be used unchanged, and every z is reachable.
  /// Otherwise does nothing and returns false.
  template <int kBlock>
  bool step_block(const Rows& y, int first) {
    int started = 0;
    for (int n = first; n < first + kBlock; ++n) started += started_[n];
    if (started != kBlock || !static_cast<Batch*>(this)->template advance_block<kBlock>(y, first)) return false;
    for (int n = first; n < first + kBlock; ++n) {
      for (int j = 0; j < kNr; ++j) health_[j][n] = 0;
      status_[n] = StepStatus::kOk;
    }
    return true;
  }

  template <int kTogether>
  void estimate_block(Scalar (&x_hat)[kNx][kPlants], int first) const {
    using Map = typename Model::InverseMap;
    constexpr int kIn = Map::kIn;
    alignas(kAlignment) Scalar in[kIn * kTogether], out[kNx * kTogether];
    for (int i = 0; i < kIn; ++i) {
      const Scalar* from = i < kNz ? &z_[i][first] : &y_[i - kNz][first];
      for (int n = 0; n < kTogether; ++n) in[i * kTogether + n] = from[n];
    }
    if constexpr (kSaturates) {
      for (int n = 0; n < kTogether; ++n) {
        Scalar z[kNz], y[kNr], within[kNz];
        for (int r = 0; r < kNz; ++r) z[r] = z_[r][first + n];
        for (int j = 0; j < kNr; ++j) y[j] = y_[j][first + n];
        saturate<kArithmetic>(*model_, y, z, within);
        for (int r = 0; r < kNz; ++r) in[r * kTogether + n] = within[r];
      }
    }
    nlo::evaluate_batch<kArithmetic, kTogether>(model_->inverse_map, in, out);
    const int count = kPlants - first < kTogether ? kPlants - first : kTogether;
    for (int i = 0; i < kNx; ++i) {
      for (int n = 0; n < count; ++n) x_hat[i][first + n] = out[i * kTogether + n];
    }
  }

  ChannelHealth health_[kNr][kPadded];
  StepStatus status_[kPadded];
  std::uint8_t started_[kPadded];
};

}  // namespace nlo::inline NLO_ISA
