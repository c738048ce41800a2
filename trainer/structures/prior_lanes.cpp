// SPDX-License-Identifier: MIT
#include "trainer/structures/prior_lanes.h"

#include <nlo/explicit_rk.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "trainer/gradients/nn/block_products.h"
#include "trainer/structures/lane_numbers.h"

namespace nlo::trainer {
namespace {

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
      update_(setting.nx(), setting.ny()),
      measured_(setting.nx(), setting.ny()),
      to_measured_(measured_),
      expected_(static_cast<std::size_t>(setting.ny() * (1 + setting.nx()))),
      to_expected_(expected_),
      gain_(lanes(setting.corrections())),
      correction_transposed_(static_cast<std::size_t>(units_.columns() * setting.corrections())),
      x_(static_cast<std::size_t>(setting.carried())),
      to_x_(x_),
      to_squashed_(lanes(setting.ny())),
      to_gain_(gain_),
      to_in_(lanes(units_.columns())),
      gradient_(static_cast<std::size_t>(units_.columns() * setting.corrections() *
                                         Products<Scalar, kGroup>::kLanesPerWeight)),
      bias_gradient_(gain_) {
  static_assert(Products<Scalar, kGroup>::kStride == kGroup);
  const auto deviation = [this](int i) { return setting_.read.scale[static_cast<std::size_t>(prior_row() + i)]; };
  for (int i = 0; i < setting.nx(); ++i) unit_.push_back(static_cast<Scalar>(deviation(i)));
  for (int i = 0; i < setting.nx(); ++i)
    for (int j = i; j < setting.nx(); ++j) unit_.push_back(static_cast<Scalar>(deviation(i) * deviation(j)));
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
  prior_.resize(static_cast<std::size_t>(setting_.carried() * run.length));
  run_.readings = w_.data();
}

template <class Scalar>
auto PriorLanes<Scalar>::cut(int time) const -> Cut {
  Cut cut{.pieces = {}, .most = 1, .h = L(setting_.period_s)};
  cut.pieces.fill(1);
  if (run_.periods == nullptr) return cut;
  for (int l = 0; l < kGroup; ++l) {
    int& pieces = cut.pieces[static_cast<std::size_t>(l)];
    pieces = pieces_of(periods(time, l), Scalar(1));
    cut.h.at[l] = periods(time, l) * static_cast<Scalar>(setting_.period_s) / static_cast<Scalar>(pieces);
    cut.most = std::max(cut.most, pieces);
  }
  return cut;
}

/// 0 where a lane has arrived.
template <class Scalar>
auto PriorLanes<Scalar>::step_of(const Cut& cut, int piece) const -> L {
  L h = cut.h;
  for (int l = 0; l < kGroup; ++l)
    if (piece >= cut.pieces[static_cast<std::size_t>(l)]) h.at[l] = Scalar(0);
  return h;
}

template <class Scalar>
void PriorLanes<Scalar>::inputs_at(const Cut& cut, int time, int piece, double c, L* u) const {
  for (int j = 0; j < setting_.inputs; ++j) {
    // w has the readings from row 2 n_y on, outputs first.
    const int row = 3 * setting_.ny() + j;
    const Scalar *to = w(row, time), *from = setting_.commands ? to : w(row, time - 1);
    for (int l = 0; l < kGroup; ++l) {
      const Scalar part = (static_cast<Scalar>(piece) + static_cast<Scalar>(c)) /
                          static_cast<Scalar>(cut.pieces[static_cast<std::size_t>(l)]);
      u[j].at[l] = (1 - part) * from[l] + part * to[l];
    }
  }
}

template <class Scalar>
void PriorLanes<Scalar>::predict(L* x, int time) {
  const Cut cut = this->cut(time);
  path_.resize(std::max(path_.size(), static_cast<std::size_t>(cut.most)));
  for (int i = 0; i < cut.most; ++i) {
    Piece& piece = path_[static_cast<std::size_t>(i)];
    setting_.equations.step(
        x, step_of(cut, i), [&](double c, L* u) { inputs_at(cut, time, i, c, u); }, &piece.stages);
    for (int r = 0; r < setting_.carried(); ++r) {
      const auto row = static_cast<std::size_t>(r);
      piece.reached[row] = x[r];
      x[r] = kept_within(x[r], setting_.low[row], setting_.high[row]);
    }
  }
}

/// The cotangent of the prior of `time` becomes that of the sample before it.
template <class Scalar>
void PriorLanes<Scalar>::predict_back(int time, L* cotangent) {
  const Cut cut = this->cut(time);
  for (int i = cut.most; i-- > 0;) {
    const Piece& piece = path_[static_cast<std::size_t>(i)];
    for (int r = 0; r < setting_.carried(); ++r)
      for (int l = 0; l < kGroup; ++l) {
        const Scalar reached = piece.reached[static_cast<std::size_t>(r)].at[l];
        if (reached < low(r) || reached > high(r)) cotangent[r].at[l] = Scalar(0);
      }
    setting_.equations.step_back(
        piece.stages, step_of(cut, i), [&](double c, L* u) { inputs_at(cut, time, i, c, u); }, cotangent);
  }
}

/// The readings of a sample: the measurement, the prior, and the innovation.
template <class Scalar>
void PriorLanes<Scalar>::read(int time) {
  const int nx = setting_.nx(), ny = setting_.ny();
  for (int r = 0; r < setting_.readings; ++r)
    std::copy_n(given_ + (static_cast<std::ptrdiff_t>(r) * run_.length + time) * kGroup, kGroup, w(2 * ny + r, time));
  L* const prior = this->prior(time);
  for (int i = 0; i < setting_.carried(); ++i)
    prior[i] = time == 0 ? L(setting_.start[static_cast<std::size_t>(i)]) : L(x(i, time - 1));
  if (time > 0) predict(prior, time);
  for (int i = 0; i < nx; ++i) std::copy_n(prior[i].at, kGroup, w(prior_row() + i, time));
  setting_.equations.output(prior, expected_.data());
  for (int j = 0; j < ny; ++j) {
    const auto row = static_cast<std::size_t>(j);
    const auto fine = static_cast<Scalar>(setting_.fine[row]), coarse = static_cast<Scalar>(setting_.coarse[row]);
    for (int l = 0; l < kGroup; ++l) {
      const Scalar nu = arrived(j, time, l) * (w(2 * ny + j, time)[l] - expected_[row].at[l]);
      w(j, time)[l] = nu / (fine + std::abs(nu));
      w(ny + j, time)[l] = nu / (coarse + std::abs(nu));
    }
  }
}

template <class Scalar>
auto PriorLanes<Scalar>::noise(int correction) const -> L {
  L result;
  for (int l = 0; l < kGroup; ++l)
    result.at[l] = std::exp(std::clamp(gain_[lane(correction, l)], Scalar(-16), Scalar(16)));
  return result;
}

/// From the cotangent of a variance, which is proportional to noise(correction), to that of the output of the
/// correction's layer has there.
template <class Scalar>
void PriorLanes<Scalar>::noise_back(int correction, const L& variance, const L& to_variance) {
  for (int l = 0; l < kGroup; ++l) {
    const bool inside = std::abs(gain_[lane(correction, l)]) < Scalar(16);
    to_gain_[lane(correction, l)] = inside ? to_variance.at[l] * variance.at[l] * scale(correction) : Scalar(0);
  }
}

/// Fills gain_ from [m; w], measured_, and x_: the corrected prior before it is clamped to the range.
template <class Scalar>
void PriorLanes<Scalar>::correct(const Scalar* in, int time) {
  const int first = 3 * setting_.units, nx = setting_.nx(), ny = setting_.ny();
  product<Scalar>(units_.weights(first), setting_.corrections(), units_.columns(), units_.bias(first), in,
                  gain_.data());
  for (int r = 0; r < setting_.corrections(); ++r)
    for (int l = 0; l < kGroup; ++l) gain_[lane(r, l)] *= scale(r);
  const L* const prior = this->prior(time);
  setting_.equations.output(prior, expected_.data());
  std::copy_n(prior + nx, measured_.p.size(), measured_.p.begin());
  std::copy_n(expected_.begin() + ny, measured_.slopes.size(), measured_.slopes.begin());
  for (int j = 0; j < ny; ++j) {
    const auto row = static_cast<std::size_t>(j);
    for (int l = 0; l < kGroup; ++l) measured_.arrived[row].at[l] = arrived(j, time, l);
    measured_.innovations[row] = measured_.arrived[row] * (L(w(2 * ny + j, time)) - expected_[row]);
    measured_.r[row] = L(setting_.output_noise[row]) * noise(noise_row() + nx + j);
  }
  for (int i = 0; i < nx; ++i) {
    const auto row = static_cast<std::size_t>(i);
    measured_.q[row] = L(setting_.state_noise[row]) * noise(noise_row() + i);
    for (int l = 0; l < kGroup; ++l) measured_.q[row].at[l] *= periods(time, l);
  }
  update_.forward(measured_);
  for (int i = 0; i < nx; ++i) {
    const auto row = static_cast<std::size_t>(i);
    x_[row] = prior[i] + measured_.change[row];
    for (int l = 0; l < kGroup; ++l) {
      Scalar learned = gain_[lane(nx * ny + i, l)];
      for (int j = 0; j < ny; ++j) learned += gain_[lane(i * ny + j, l)] * w(ny + j, time)[l];
      x_[row].at[l] += learned;
    }
  }
  std::copy(measured_.p.begin(), measured_.p.end(), x_.begin() + nx);
}

template <class Scalar>
void PriorLanes<Scalar>::stepped(int time, const Scalar* in) {
  correct(in, time);
  for (int i = 0; i < setting_.carried(); ++i)
    for (int l = 0; l < kGroup; ++l) x(i, time)[l] = std::clamp(x_[static_cast<std::size_t>(i)].at[l], low(i), high(i));
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
  std::fill(to_x_.begin(), to_x_.end(), L(0.0));
  for (std::vector<Scalar>* sums : {&gradient_, &bias_gradient_}) std::fill(sums->begin(), sums->end(), Scalar(0));
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

/// Pulls dl/d[x; p] of a sample back to the correction's weights and to its readings. If a run has lost its filter, so
/// that its end depends on its beginning a thousand times more than its loss is large, only later samples teach.
template <class Scalar>
void PriorLanes<Scalar>::pull_back(int time, const Scalar* in, Scalar* to_z) {
  constexpr Scalar kLost = Scalar(1000), kFinite = Scalar(1e6);
  const int nx = setting_.nx(), ny = setting_.ny(), rows = setting_.corrections(), columns = units_.columns();
  correct(in, time);
  for (int i = 0; i < setting_.carried(); ++i) {
    const auto row = static_cast<std::size_t>(i);
    const Scalar* own =
        run_.cotangent + (static_cast<std::ptrdiff_t>(setting_.units + i) * run_.length + time) * kGroup;
    for (int l = 0; l < kGroup; ++l) {
      const bool inside = x_[row].at[l] >= low(i) && x_[row].at[l] <= high(i);
      const Scalar to = to_x_[row].at[l] + own[l];
      const bool lost = !(std::abs(to) * unit_[row] < kLost);
      to_x_[row].at[l] = inside && !lost ? to : Scalar(0);
    }
  }
  std::fill(to_squashed_.begin(), to_squashed_.end(), Scalar(0));
  for (int i = 0; i < nx; ++i)
    for (int l = 0; l < kGroup; ++l) {
      const Scalar to = to_x_[static_cast<std::size_t>(i)].at[l];
      to_gain_[lane(nx * ny + i, l)] = to * scale(nx * ny + i);
      for (int j = 0; j < ny; ++j) {
        to_gain_[lane(i * ny + j, l)] = to * w(ny + j, time)[l] * scale(i * ny + j);
        to_squashed_[lane(j, l)] += to * gain_[lane(i * ny + j, l)];
      }
    }
  std::copy_n(to_x_.begin(), nx, to_measured_.change.begin());
  std::copy(to_x_.begin() + nx, to_x_.end(), to_measured_.p.begin());
  update_.backward(measured_, to_measured_);
  std::copy(to_measured_.p.begin(), to_measured_.p.end(), to_x_.begin() + nx);
  for (int i = 0; i < nx; ++i) {
    const auto row = static_cast<std::size_t>(i);
    noise_back(noise_row() + i, measured_.q[row], to_measured_.q[row]);
  }
  for (int j = 0; j < ny; ++j) {
    const auto row = static_cast<std::size_t>(j);
    noise_back(noise_row() + nx + j, measured_.r[row], to_measured_.r[row]);
  }
  for (Scalar& to : to_gain_)
    if (!(std::abs(to) < kFinite)) to = Scalar(0);
  Products<Scalar, kGroup>::outer_product(to_gain_.data(), rows, in, columns, gradient_.data());
  for (std::size_t i = 0; i < to_gain_.size(); ++i) bias_gradient_[i] += to_gain_[i];
  product<Scalar>(correction_transposed_.data(), columns, rows, nullptr, to_gain_.data(), to_in_.data());
  for (std::size_t i = 0; i < lane(setting_.units, 0); ++i) to_z[i] += to_in_[i];
}

/// From the cotangents of the units' inputs and to_x_ to dl/d[x; p] of the previous sample.
template <class Scalar>
void PriorLanes<Scalar>::take(int time, const Scalar* to_readings) {
  const int nx = setting_.nx(), ny = setting_.ny();
  const auto to_w = [&](int row, int l) {
    const auto scale = static_cast<Scalar>(setting_.read.scale[static_cast<std::size_t>(row)]);
    return (to_readings[lane(row, l)] + to_in_[lane(setting_.units + row, l)]) / scale;
  };
  if (time == 0) return;
  for (int i = 0; i < nx; ++i)
    for (int l = 0; l < kGroup; ++l) to_x_[static_cast<std::size_t>(i)].at[l] += to_w(prior_row() + i, l);
  for (int j = 0; j < ny; ++j) {
    const auto row = static_cast<std::size_t>(j);
    // ds/dnu = c / (c + |nu|)^2, and 1 - |s| = c / (c + |nu|)
    const auto slope = [](Scalar s, double c) {
      return (1 - std::abs(s)) * (1 - std::abs(s)) / static_cast<Scalar>(c);
    };
    for (int l = 0; l < kGroup; ++l)
      to_expected_[row].at[l] =
          arrived(j, time, l) *
          (-(to_squashed_[lane(j, l)] + to_w(ny + j, l)) * slope(w(ny + j, time)[l], setting_.coarse[row]) -
           to_w(j, l) * slope(w(j, time)[l], setting_.fine[row]) - to_measured_.innovations[row].at[l]);
  }
  std::copy(to_measured_.slopes.begin(), to_measured_.slopes.end(), to_expected_.begin() + ny);
  std::vector<L> at(static_cast<std::size_t>(setting_.carried()));
  setting_.equations.output_back(prior(time), to_expected_.data(), to_x_.data());
  for (int i = 0; i < setting_.carried(); ++i) at[static_cast<std::size_t>(i)] = L(x(i, time - 1));
  predict(at.data(), time);
  predict_back(time, to_x_.data());
}

template class PriorLanes<float>;
template class PriorLanes<double>;

}  // namespace nlo::trainer
