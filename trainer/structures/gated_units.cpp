// SPDX-License-Identifier: MIT
#include "trainer/structures/gated_units.h"

#include <algorithm>
#include <cmath>

#include "nlo/gate.h"
#include "trainer/gradients/nn/block_activation.h"
#include "trainer/gradients/nn/block_products.h"

namespace nlo::trainer {
namespace {

constexpr int kChunkSamples = 32;
constexpr int kChunkColumns = kChunkSamples * kGroup;

template <class Scalar>
using One = Products<Scalar, kGroup>;
template <class Scalar>
using Many = Products<Scalar, kChunkColumns>;

template <class Scalar>
constexpr std::size_t kStride = static_cast<std::size_t>(Many<Scalar>::kStride);

template <class Scalar>
AlignedVector<Scalar> rows(int count, std::size_t stride) {
  return AlignedVector<Scalar>(static_cast<std::size_t>(count) * stride, Scalar(0));
}

/// Writes W column by column, `stride` apart.
template <class Math, class Scalar>
void product(const Scalar* w, int stride, int row_count, int columns, const Scalar* bias, const Scalar* in,
             Scalar* out) {
  Math::product_by_columns(w, stride, row_count, columns, bias, in,
                           [=](int row, int s, typename Math::P v) NLO_INLINE_LAMBDA {
                             simd::store(out + static_cast<std::ptrdiff_t>(row) * Math::kStride + s, v);
                           });
}

/// Calls each(at, register) for [0, size), with whole registers first, then with registers of eight scalars.
template <class Scalar, class Each>
void by_registers(std::size_t size, const Each& each) {
  constexpr int kWide = simd::kLanes<Scalar>, kNarrow = std::min(kWide, kGroup);
  std::size_t at = 0;
  for (; at + kWide <= size; at += kWide) each(at, simd::Pack<Scalar, kWide>{});
  for (; at < size; at += kNarrow) each(at, simd::Pack<Scalar, kNarrow>{});
}

}  // namespace

template <class Scalar>
GatedUnits<Scalar>::GatedUnits(int units, const Normalisation& readings, int others)
    : units_(units),
      readings_(static_cast<int>(readings.mean.size())),
      columns_(units + readings_),
      others_(others),
      by_columns_(rows<Scalar>(columns_, static_cast<std::size_t>(3 * units))),
      in_(rows<Scalar>(columns_, kGroup)),
      gate_(rows<Scalar>(2 * units, kGroup)),
      target_(rows<Scalar>(units, kGroup)),
      z_(rows<Scalar>(units, kGroup)),
      p_(z_),
      to_all_(rows<Scalar>(3 * units, kGroup)),
      pulled_(z_),
      to_readings_(rows<Scalar>(readings_, kGroup)),
      chunk_in_(rows<Scalar>(columns_, kStride<Scalar>)),
      chunk_reset_in_(chunk_in_),
      chunk_raw_(rows<Scalar>(units, kStride<Scalar>)),
      chunk_gate_(rows<Scalar>(2 * units, kStride<Scalar>)),
      chunk_target_(chunk_raw_),
      chunk_own_(chunk_raw_),
      chunk_cotangent_(rows<Scalar>(3 * units, kStride<Scalar>)),
      gradient_(static_cast<std::size_t>(parameters())) {
  static_assert(Many<Scalar>::kLanesPerWeight == 1);
  for (std::size_t j = 0; j < readings.mean.size(); ++j) {
    mean_.push_back(static_cast<Scalar>(readings.mean[j]));
    inverse_scale_.push_back(static_cast<Scalar>(1.0 / readings.scale[j]));
  }
}

template <class Scalar>
void GatedUnits<Scalar>::prepare(const Scalar* theta) {
  theta_ = theta;
  for (int i = 0; i < columns_; ++i)
    for (int o = 0; o < 3 * units_; ++o) by_columns_[static_cast<std::size_t>(i * 3 * units_ + o)] = weights(o)[i];
}

/// Writes the normalised readings of a sample below z in in_.
template <class Scalar>
void GatedUnits<Scalar>::gather_readings(const GatedRun<Scalar>& run, int time) {
  for (int j = 0; j < readings_; ++j) {
    const Scalar* y = run.readings + (static_cast<std::ptrdiff_t>(j) * run.length + time) * kGroup;
    Scalar* to = in_.data() + static_cast<std::ptrdiff_t>(units_ + j) * kGroup;
    const auto row = static_cast<std::size_t>(j);
    for (int l = 0; l < kGroup; ++l) to[l] = (y[l] - mean_[row]) * inverse_scale_[row];
  }
}

/// Computes gates and targets of adjacent columns, as gated.inc of the runtime does.
///   in          [z; readings]
///   raw_share   argument of the tanh of the share; null: not stored
///   gate        tanh for the share, then tanh for the reset
///   reset_in    has the readings already; its z becomes that of `in` after the reset; may be `in`
template <class Scalar>
template <class Math>
void GatedUnits<Scalar>::pull(const Scalar* in, Scalar* raw_share, Scalar* gate, Scalar* reset_in,
                              Scalar* target) const {
  const auto size = static_cast<std::size_t>(units_) * static_cast<std::size_t>(Math::kStride);
  product<Math>(by_columns_.data(), 3 * units_, 2 * units_, columns_, bias(0), in, gate);
  if (raw_share != nullptr) std::copy_n(gate, size, raw_share);
  by_registers<Scalar>(size, [&]<class P>(std::size_t i, P) NLO_INLINE_LAMBDA {
    const P reset = smooth_tanh(simd::load<P>(gate + size + i));
    simd::store(gate + size + i, reset);
    simd::store(gate + i, smooth_tanh(simd::load<P>(gate + i)));
    simd::store(reset_in + i, simd::load<P>(in + i) * gate_of(reset));
  });
  product<Math>(by_columns_.data() + 2 * units_, 3 * units_, units_, columns_, bias(2 * units_), reset_in, target);
  by_registers<Scalar>(size, [&]<class P>(std::size_t i, P) NLO_INLINE_LAMBDA {
    simd::store(target + i, smooth_tanh(simd::load<P>(target + i)));
  });
}

template <class Scalar>
void GatedUnits<Scalar>::forward(const GatedRun<Scalar>& run, GatedLoop<Scalar>* loop) {
  const std::size_t size = z_.size();
  AlignedVector<Scalar>& share = pulled_;
  std::fill(z_.begin(), z_.end(), Scalar(0));
  for (int k = 0; k < run.length; ++k) {
    std::copy(z_.begin(), z_.end(), in_.begin());
    if (loop != nullptr) loop->read(k);
    gather_readings(run, k);
    const bool regular = run.periods == nullptr;
    pull<One<Scalar>>(in_.data(), regular ? nullptr : share.data(), gate_.data(), in_.data(), target_.data());
    for (std::size_t i = 0; !regular && i < size; ++i)
      share[i] = gate_over(share[i], run.periods[k * kGroup + static_cast<int>(i % kGroup)]);
    by_registers<Scalar>(size, [&]<class P>(std::size_t i, P) NLO_INLINE_LAMBDA {
      const P z = simd::load<P>(z_.data() + i), c = simd::load<P>(target_.data() + i);
      const P s = regular ? gate_of(simd::load<P>(gate_.data() + i)) : simd::load<P>(share.data() + i);
      simd::store(z_.data() + i, z + s * (c - z));
    });
    for (int r = 0; r < units_; ++r)
      std::copy_n(z_.data() + static_cast<std::ptrdiff_t>(r) * kGroup, kGroup,
                  run.latent + (static_cast<std::ptrdiff_t>(r) * run.length + k) * kGroup);
    if (loop == nullptr) continue;
    std::copy(z_.begin(), z_.end(), in_.begin());
    loop->stepped(k, in_.data());
  }
}

/// Computes gates and targets of a chunk from the z that forward() has stored. Columns after the chunk are zero.
template <class Scalar>
void GatedUnits<Scalar>::repeat(const GatedRun<Scalar>& run, Chunk chunk) {
  const int used = chunk.count * kGroup;
  const auto row_of = [](AlignedVector<Scalar>& rows, int row) {
    return rows.data() + static_cast<std::size_t>(row) * kStride<Scalar>;
  };
  for (int r = 0; r < units_; ++r) {
    Scalar* to = row_of(chunk_in_, r);
    const int missing = chunk.from == 0 ? kGroup : 0;  // z before the first sample is zero
    std::fill(to, to + kChunkColumns, Scalar(0));
    const Scalar* z = run.latent + (static_cast<std::ptrdiff_t>(r) * run.length + chunk.from - 1) * kGroup;
    std::copy(z + missing, z + used, to + missing);
  }
  for (int j = 0; j < readings_; ++j) {
    Scalar* to = row_of(chunk_in_, units_ + j);
    std::fill(to, to + kChunkColumns, Scalar(0));
    const Scalar* y = run.readings + (static_cast<std::ptrdiff_t>(j) * run.length + chunk.from) * kGroup;
    const auto row = static_cast<std::size_t>(j);
    for (int i = 0; i < used; ++i) to[i] = (y[i] - mean_[row]) * inverse_scale_[row];
    std::copy_n(to, kChunkColumns, row_of(chunk_reset_in_, units_ + j));
  }
  pull<Many<Scalar>>(chunk_in_.data(), run.periods != nullptr ? chunk_raw_.data() : nullptr, chunk_gate_.data(),
                     chunk_reset_in_.data(), chunk_target_.data());
}

/// Replaces p_ of a sample by p_ of the previous sample, without the previous sample's own cotangent. `column` is the
/// first column of the sample.
template <class Scalar>
void GatedUnits<Scalar>::pull_back(const GatedRun<Scalar>& run, int time, int column) {
  using P = typename One<Scalar>::P;
  constexpr int kWidth = One<Scalar>::kWidth;
  const P half = P{} + simd::literal<P>(0.5), one = P{} + simd::literal<P>(1.0);
  Scalar* to_candidate = to_all_.data() + 2 * p_.size();
  for (int r = 0; r < units_; ++r) {
    const std::size_t at = static_cast<std::size_t>(r) * kStride<Scalar> + static_cast<std::size_t>(column);
    for (int l = 0; l < kGroup; l += kWidth) {
      const int i = r * kGroup + l;
      const std::size_t in_chunk = at + static_cast<std::size_t>(l);
      const P p = simd::load<P>(p_.data() + i), z = simd::load<P>(chunk_in_.data() + in_chunk);
      const P c = simd::load<P>(chunk_target_.data() + in_chunk), t = simd::load<P>(chunk_gate_.data() + in_chunk);
      P share = gate_of(t), slope = half * (one - t * t);
      if (run.periods != nullptr) {  // s = 1 - exp(-m softplus(2 a)): ds/da = m (1 - s) (1 + tanh a)
        Scalar shares[kWidth], slopes[kWidth];
        for (int n = 0; n < kWidth; ++n) {
          const Scalar periods = run.periods[time * kGroup + l + n];
          shares[n] = gate_over(chunk_raw_[in_chunk + static_cast<std::size_t>(n)], periods);
          slopes[n] = periods * (1 - shares[n]) * (1 + chunk_gate_[in_chunk + static_cast<std::size_t>(n)]);
        }
        share = simd::load<P>(shares);
        slope = simd::load<P>(slopes);
      }
      simd::store(to_all_.data() + i, p * (c - z) * slope);
      simd::store(to_candidate + i, p * share * (one - c * c));
      simd::store(p_.data() + i, p * (one - share));
    }
  }
  product<One<Scalar>>(weights(2 * units_), columns_, units_, units_, static_cast<const Scalar*>(nullptr),
                       static_cast<const Scalar*>(to_candidate), pulled_.data());
  const std::size_t size = p_.size();
  for (int r = 0; r < units_; ++r) {
    const std::size_t at = static_cast<std::size_t>(r) * kStride<Scalar> + static_cast<std::size_t>(column);
    for (int l = 0; l < kGroup; l += kWidth) {
      const int i = r * kGroup + l;
      const std::size_t in_chunk = at + static_cast<std::size_t>(l);
      const P q = simd::load<P>(pulled_.data() + i), z = simd::load<P>(chunk_in_.data() + in_chunk);
      const P t = simd::load<P>(chunk_gate_.data() + static_cast<std::size_t>(units_) * kStride<Scalar> + in_chunk);
      simd::store(to_all_.data() + size + static_cast<std::size_t>(i), q * z * half * (one - t * t));
      simd::store(p_.data() + i, simd::load<P>(p_.data() + i) + q * gate_of(t));
    }
  }
  product<One<Scalar>>(weights(0), columns_, units_, 2 * units_, static_cast<const Scalar*>(nullptr),
                       static_cast<const Scalar*>(to_all_.data()), pulled_.data());
  for (std::size_t i = 0; i < size; ++i) p_[i] += pulled_[i];
  for (int r = 0; r < 3 * units_; ++r)
    std::copy_n(
        to_all_.data() + static_cast<std::ptrdiff_t>(r) * kGroup, kGroup,
        chunk_cotangent_.data() + static_cast<std::size_t>(r) * kStride<Scalar> + static_cast<std::size_t>(column));
}

template <class Scalar>
void GatedUnits<Scalar>::backward(const GatedRun<Scalar>& run, std::vector<double>& gradient, GatedLoop<Scalar>* loop) {
  std::fill(gradient_.begin(), gradient_.end(), Scalar(0));
  std::fill(p_.begin(), p_.end(), Scalar(0));
  const auto add_cotangent = [&](int column) {
    for (int r = 0; r < units_; ++r) {
      const Scalar* own = chunk_own_.data() + static_cast<std::size_t>(r) * kStride<Scalar> + column;
      Scalar* p = p_.data() + static_cast<std::ptrdiff_t>(r) * kGroup;
      for (int l = 0; l < kGroup; ++l) p[l] += own[l];
    }
  };
  for (int from = (run.length - 1) / kChunkSamples * kChunkSamples; from >= 0; from -= kChunkSamples) {
    const Chunk chunk{from, std::min(kChunkSamples, run.length - from)};
    if (loop != nullptr) loop->repeat(chunk.from, chunk.count);
    repeat(run, chunk);
    // Row by row, because a copy sample by sample would read the cotangents from as many places as there are units.
    for (int r = 0; r < units_; ++r)
      std::copy_n(run.cotangent + (static_cast<std::ptrdiff_t>(r) * run.length + from) * kGroup, chunk.count * kGroup,
                  chunk_own_.data() + static_cast<std::size_t>(r) * kStride<Scalar>);
    if (chunk.count < kChunkSamples) std::fill(chunk_cotangent_.begin(), chunk_cotangent_.end(), Scalar(0));
    for (int k = chunk.count - 1; k >= 0; --k) {
      add_cotangent(k * kGroup);
      if (loop != nullptr) {
        for (int r = 0; r < units_; ++r)
          std::copy_n(run.latent + (static_cast<std::ptrdiff_t>(r) * run.length + from + k) * kGroup, kGroup,
                      in_.data() + static_cast<std::ptrdiff_t>(r) * kGroup);
        gather_readings(run, from + k);
        loop->pull_back(from + k, in_.data(), p_.data());
      }
      pull_back(run, from + k, k * kGroup);
      if (loop == nullptr) continue;
      product<One<Scalar>>(weights(0) + units_, columns_, readings_, 3 * units_, static_cast<const Scalar*>(nullptr),
                           static_cast<const Scalar*>(to_all_.data()), to_readings_.data());
      loop->take(from + k, to_readings_.data());
    }
    const Scalar* to_candidate = chunk_cotangent_.data() + static_cast<std::size_t>(2 * units_) * kStride<Scalar>;
    Many<Scalar>::outer_product(chunk_cotangent_.data(), 2 * units_, chunk_in_.data(), columns_, gradient_.data());
    Many<Scalar>::outer_product(to_candidate, units_, chunk_reset_in_.data(), columns_,
                                gradient_.data() + 2 * units_ * columns_);
    Many<Scalar>::row_sums(chunk_cotangent_.data(), 3 * units_, gradient_.data() + (3 * units_ + others_) * columns_);
  }
  gradient.assign(gradient_.begin(), gradient_.end());
}

template class GatedUnits<float>;
template class GatedUnits<double>;

}  // namespace nlo::trainer
