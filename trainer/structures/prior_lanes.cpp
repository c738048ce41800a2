// SPDX-License-Identifier: MIT
#include "trainer/structures/prior_lanes.h"

#include <nlo/explicit_rk.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "trainer/nn/block_products.h"
#include "trainer/structures/lane_numbers.h"

namespace nlo::trainer {
namespace {

template <class Scalar>
using States = std::array<Lanes<Scalar>, codegen::Equations::kMostStates>;
template <class Scalar>
using DualStates = std::array<DualOf<Lanes<Scalar>>, codegen::Equations::kMostStates>;
template <class Value>
using Outputs = std::array<Value, codegen::Equations::kMostOutputs>;

/// x with the derivative by x_i.
template <class Scalar>
DualStates<Scalar> seeded(const States<Scalar>& x, int count, int i) {
  DualStates<Scalar> dual;
  for (int r = 0; r < count; ++r) {
    const auto row = static_cast<std::size_t>(r);
    dual[row] = {x[row], Lanes<Scalar>(r == i ? 1.0 : 0.0)};
  }
  return dual;
}

/// Place in an array of rows of eight.
std::size_t lane(int row, int l) {
  return static_cast<std::size_t>(row) * kGroup + static_cast<std::size_t>(l);
}
std::size_t lanes(int rows) {
  return lane(rows, 0);
}

template <class Scalar>
void product(const Scalar* w, int rows, int columns, const Scalar* bias, const Scalar* in, Scalar* out) {
  using Math = Products<Scalar, kGroup>;
  Math::product(w, rows, columns, bias, in, [=](int row, int s, typename Math::P v) NLO_INLINE_LAMBDA {
    simd::store(out + static_cast<std::ptrdiff_t>(row) * Math::kStride + s, v);
  });
}

}  // namespace

template <class Scalar>
PriorLanes<Scalar>::PriorLanes(const PriorSetting& setting)
    : setting_(setting),
      units_(setting.units, setting.read, setting.corrections()),
      gain_(lanes(setting.corrections())),
      correction_transposed_(static_cast<std::size_t>(units_.columns() * setting.corrections())),
      p_(lanes(setting.nx())),
      x_(p_),
      to_prior_(p_),
      to_squashed_(lanes(setting.ny())),
      to_gain_(gain_),
      to_in_(lanes(units_.columns())),
      gradient_(static_cast<std::size_t>(units_.columns() * setting.corrections() *
                                         Products<Scalar, kGroup>::kLanesPerWeight)),
      bias_gradient_(gain_) {
  static_assert(Products<Scalar, kGroup>::kStride == kGroup);
}

template <class Scalar>
void PriorLanes<Scalar>::prepare(const Scalar* theta) {
  units_.prepare(theta);
  const int rows = setting_.corrections();
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < units_.columns(); ++c)
      correction_transposed_[static_cast<std::size_t>(c * rows + r)] = units_.weights(3 * setting_.units + r)[c];
}

template <class Scalar>
void PriorLanes<Scalar>::begin(const GatedRun<Scalar>& run) {
  run_ = run;
  given_ = run.readings;
  w_.resize(lanes(setting_.reads() * run.length));
  run_.readings = w_.data();
}

template <class Scalar>
template <class Value>
void PriorLanes<Scalar>::predict(Value* x, int time) const {
  using L = Lanes<Scalar>;
  std::array<int, kGroup> pieces;
  pieces.fill(1);
  L h(setting_.period_s);
  if (run_.periods != nullptr)
    for (int l = 0; l < kGroup; ++l) {
      const Scalar periods = run_.periods[time * kGroup + l];
      pieces[static_cast<std::size_t>(l)] = pieces_of(periods, Scalar(1));
      h.at[l] =
          periods * static_cast<Scalar>(setting_.period_s) / static_cast<Scalar>(pieces[static_cast<std::size_t>(l)]);
    }
  const int most = *std::max_element(pieces.begin(), pieces.end());
  const auto u_row = [&](int j, int at) {
    // w has the readings from row 2 n_y on, outputs first.
    return w_.data() + (static_cast<std::ptrdiff_t>(3 * setting_.ny() + j) * run_.length + at) * kGroup;
  };
  for (int i = 0; i < most; ++i) {
    for (int l = 0; l < kGroup; ++l)
      if (i >= pieces[static_cast<std::size_t>(l)]) h.at[l] = Scalar(0);  // it is there
    setting_.equations.step(x, Value(h), [&](double c, Value* u) {
      for (int j = 0; j < setting_.inputs; ++j) {
        const Scalar* to = u_row(j, time);
        const Scalar* from = setting_.commands ? to : u_row(j, time - 1);
        L now;
        for (int l = 0; l < kGroup; ++l) {
          const Scalar part = (static_cast<Scalar>(i) + static_cast<Scalar>(c)) /
                              static_cast<Scalar>(pieces[static_cast<std::size_t>(l)]);
          now.at[l] = (1 - part) * from[l] + part * to[l];
        }
        u[j] = Value(now);
      }
    });
    for (int r = 0; r < setting_.nx(); ++r)
      x[r] = kept_within(x[r], setting_.low[static_cast<std::size_t>(r)], setting_.high[static_cast<std::size_t>(r)]);
  }
}

/// The readings of a sample: what was measured, the prior, and the innovation between them.
template <class Scalar>
void PriorLanes<Scalar>::read(int time) {
  const int nx = setting_.nx(), ny = setting_.ny();
  for (int r = 0; r < setting_.readings; ++r)
    std::copy_n(given_ + (static_cast<std::ptrdiff_t>(r) * run_.length + time) * kGroup, kGroup, w(2 * ny + r, time));
  States<Scalar> prior;
  for (int i = 0; i < nx; ++i) {
    const auto row = static_cast<std::size_t>(i);
    prior[row] = time == 0 ? Lanes<Scalar>(setting_.start[row]) : Lanes<Scalar>(x(i, time - 1));
  }
  if (time > 0) predict(prior.data(), time);
  for (int i = 0; i < nx; ++i) std::copy_n(prior[static_cast<std::size_t>(i)].at, kGroup, w(prior_row() + i, time));
  Outputs<Lanes<Scalar>> y;
  setting_.equations.output(prior.data(), y.data());
  for (int j = 0; j < ny; ++j) {
    const auto row = static_cast<std::size_t>(j);
    const Lanes<Scalar>& expected = y[row];
    const auto fine = static_cast<Scalar>(setting_.fine[row]), coarse = static_cast<Scalar>(setting_.coarse[row]);
    for (int l = 0; l < kGroup; ++l) {
      const Scalar nu = w(2 * ny + j, time)[l] - expected.at[l];
      w(j, time)[l] = nu / (fine + std::abs(nu));
      w(ny + j, time)[l] = nu / (coarse + std::abs(nu));
    }
  }
}

/// Fills gain_, [K; b], from [m; w], and x_, what the correction makes of the prior before x is kept within its range.
template <class Scalar>
void PriorLanes<Scalar>::correct(const Scalar* in, int time) {
  const int first = 3 * setting_.units, nx = setting_.nx(), ny = setting_.ny();
  product<Scalar>(units_.weights(first), setting_.corrections(), units_.columns(), units_.bias(first), in,
                  gain_.data());
  for (int r = 0; r < setting_.corrections(); ++r)
    for (int l = 0; l < kGroup; ++l) gain_[lane(r, l)] *= scale(r);
  for (int i = 0; i < nx; ++i)
    for (int l = 0; l < kGroup; ++l) {
      Scalar sum = w(prior_row() + i, time)[l] + gain_[lane(nx * ny + i, l)];
      for (int j = 0; j < ny; ++j) sum += gain_[lane(i * ny + j, l)] * w(ny + j, time)[l];
      x_[lane(i, l)] = sum;
    }
}

template <class Scalar>
void PriorLanes<Scalar>::stepped(int time, const Scalar* in) {
  correct(in, time);
  for (int i = 0; i < setting_.nx(); ++i)
    for (int l = 0; l < kGroup; ++l) x(i, time)[l] = std::clamp(x_[lane(i, l)], low(i), high(i));
}

template <class Scalar>
void PriorLanes<Scalar>::forward(const GatedRun<Scalar>& run) {
  begin(run);
  units_.forward(run_, this);
}

template <class Scalar>
void PriorLanes<Scalar>::backward(const GatedRun<Scalar>& run, std::vector<double>& gradient) {
  begin(run);
  for (int k = 0; k < run.length; ++k) read(k);
  for (std::vector<Scalar>* sums : {&p_, &gradient_, &bias_gradient_}) std::fill(sums->begin(), sums->end(), Scalar(0));
  units_.backward(run_, gradient, this);
  const int first = 3 * setting_.units, rows = setting_.corrections(), columns = units_.columns();
  const auto total = [](const Scalar* from, int count) {
    double sum = 0.0;
    for (int i = 0; i < count; ++i) sum += static_cast<double>(from[i]);
    return sum;
  };
  constexpr int kLanes = Products<Scalar, kGroup>::kLanesPerWeight;
  for (int i = 0; i < rows * columns; ++i)
    gradient[static_cast<std::size_t>(first * columns + i)] = total(gradient_.data() + i * kLanes, kLanes);
  for (int r = 0; r < rows; ++r)
    gradient[static_cast<std::size_t>((first + rows) * columns + first + r)] =
        total(bias_gradient_.data() + r * kGroup, kGroup);
}

/// From dl/dx of a sample to the correction's weights, and to what it reads.
template <class Scalar>
void PriorLanes<Scalar>::pull_back(int time, const Scalar* in, Scalar* to_z) {
  const int nx = setting_.nx(), ny = setting_.ny(), rows = setting_.corrections(), columns = units_.columns();
  correct(in, time);
  std::fill(to_squashed_.begin(), to_squashed_.end(), Scalar(0));
  for (int i = 0; i < nx; ++i)
    for (int l = 0; l < kGroup; ++l) {
      const Scalar own =
          run_.cotangent[(static_cast<std::ptrdiff_t>(setting_.units + i) * run_.length + time) * kGroup + l];
      const bool inside = x_[lane(i, l)] >= low(i) && x_[lane(i, l)] <= high(i);
      const Scalar p = inside ? p_[lane(i, l)] + own : Scalar(0);
      p_[lane(i, l)] = p;
      to_gain_[lane(nx * ny + i, l)] = p * scale(nx * ny + i);
      for (int j = 0; j < ny; ++j) {
        to_gain_[lane(i * ny + j, l)] = p * w(ny + j, time)[l] * scale(i * ny + j);
        to_squashed_[lane(j, l)] += p * gain_[lane(i * ny + j, l)];
      }
    }
  Products<Scalar, kGroup>::outer_product(to_gain_.data(), rows, in, columns, gradient_.data());
  for (std::size_t i = 0; i < to_gain_.size(); ++i) bias_gradient_[i] += to_gain_[i];
  product<Scalar>(correction_transposed_.data(), columns, rows, nullptr, to_gain_.data(), to_in_.data());
  for (std::size_t i = 0; i < lane(setting_.units, 0); ++i) to_z[i] += to_in_[i];
}

/// From what the units read, and from p_, to dl/dx of the sample before.
template <class Scalar>
void PriorLanes<Scalar>::take(int time, const Scalar* to_readings) {
  const int nx = setting_.nx(), ny = setting_.ny();
  const auto to_w = [&](int row, int l) {
    const auto scale = static_cast<Scalar>(setting_.read.scale[static_cast<std::size_t>(row)]);
    return (to_readings[lane(row, l)] + to_in_[lane(setting_.units + row, l)]) / scale;
  };
  for (int i = 0; i < nx; ++i)
    for (int l = 0; l < kGroup; ++l) p_[lane(i, l)] += to_w(prior_row() + i, l);
  if (time == 0) return;
  States<Scalar> prior, before;
  for (int i = 0; i < nx; ++i) {
    prior[static_cast<std::size_t>(i)] = Lanes<Scalar>(w(prior_row() + i, time));
    before[static_cast<std::size_t>(i)] = Lanes<Scalar>(x(i, time - 1));
  }
  for (int j = 0; j < ny; ++j) {
    const auto row = static_cast<std::size_t>(j);
    // ds/dnu = c / (c + |nu|)^2, and 1 - |s| = c / (c + |nu|)
    const auto slope = [](Scalar s, double c) {
      return (1 - std::abs(s)) * (1 - std::abs(s)) / static_cast<Scalar>(c);
    };
    for (int l = 0; l < kGroup; ++l)
      to_squashed_[lane(j, l)] =
          (to_squashed_[lane(j, l)] + to_w(ny + j, l)) * slope(w(ny + j, time)[l], setting_.coarse[row]) +
          to_w(j, l) * slope(w(j, time)[l], setting_.fine[row]);  // dl/dnu now
  }
  for (int i = 0; i < nx; ++i) {
    const auto dual = seeded(prior, nx, i);
    Outputs<DualOf<Lanes<Scalar>>> y;
    setting_.equations.output(dual.data(), y.data());
    for (int j = 0; j < ny; ++j) {
      const Lanes<Scalar>& slope = y[static_cast<std::size_t>(j)].slope;
      for (int l = 0; l < kGroup; ++l) p_[lane(i, l)] -= to_squashed_[lane(j, l)] * slope.at[l];
    }
  }
  std::copy(p_.begin(), p_.end(), to_prior_.begin());
  for (int i = 0; i < nx; ++i) {
    auto dual = seeded(before, nx, i);
    predict(dual.data(), time);
    for (int l = 0; l < kGroup; ++l) {
      Scalar sum = 0;
      for (int r = 0; r < nx; ++r) sum += dual[static_cast<std::size_t>(r)].slope.at[l] * to_prior_[lane(r, l)];
      p_[lane(i, l)] = sum;
    }
  }
}

template class PriorLanes<float>;
template class PriorLanes<double>;

}  // namespace nlo::trainer
