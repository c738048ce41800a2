// SPDX-License-Identifier: MIT
#include "trainer/structures/prior_lanes.h"

#include <nlo/explicit_rk.h>

#include <algorithm>
#include <cmath>

#include "trainer/gradients/nn/block_products.h"
#include "trainer/structures/lane_numbers.h"

namespace nlo::trainer {
namespace {

/// Returns the index of lane `l` of a row, in an array whose rows have eight numbers.
std::size_t lane(int row, int l) {
  return static_cast<std::size_t>(row) * kGroup + static_cast<std::size_t>(l);
}
std::size_t lanes(int rows) {
  return lane(rows, 0);
}

template <class L, class Scalar>
L row_of(const std::vector<Scalar>& rows, int row) {
  return simd::load<L>(rows.data() + lane(row, 0));
}
template <class L, class Scalar>
void set_row(std::vector<Scalar>& rows, int row, L value) {
  simd::store(rows.data() + lane(row, 0), value);
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
      equations_(setting.equations),
      update_(setting.nx(), setting.ny()),
      measured_(setting.nx(), setting.ny()),
      to_measured_(measured_),
      samples_(1),
      to_expected_(static_cast<std::size_t>(setting.ny())),
      gain_(lanes(setting.corrections())),
      correction_transposed_(static_cast<std::size_t>(units_.columns() * setting.corrections())),
      x_(static_cast<std::size_t>(setting.carried())),
      to_x_(x_),
      to_squashed_(static_cast<std::size_t>(setting.ny())),
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
  run_.readings = w_.data();
}

template <class Scalar>
auto PriorLanes<Scalar>::arrived(int j, int time) const -> L {
  L result = in_lanes<L>(1.0);
  if (run_.held == nullptr) return result;
  const std::uint8_t* held = run_.held + (static_cast<std::ptrdiff_t>(j) * run_.length + time) * kGroup;
  for (int l = 0; l < kGroup; ++l) result[l] = held[l] == 0 ? Scalar(1) : Scalar(0);
  return result;
}

template <class Scalar>
auto PriorLanes<Scalar>::cut(int time) const -> Cut {
  const L periods = this->periods(time);
  Cut cut{.pieces = in_lanes<L>(1.0), .h = periods * in_lanes<L>(setting_.period_s), .most = 1};
  if (run_.periods == nullptr) return cut;
  for (int l = 0; l < kGroup; ++l) {
    const int pieces = pieces_of(Scalar(periods[l]), Scalar(1));
    cut.pieces[l] = static_cast<Scalar>(pieces);
    cut.most = std::max(cut.most, pieces);
  }
  cut.h /= cut.pieces;
  return cut;
}

/// Returns the length of a piece, 0 in lanes that have fewer pieces.
template <class Scalar>
auto PriorLanes<Scalar>::step_of(const Cut& cut, int piece) const -> L {
  return in_lanes<L>(piece) < cut.pieces ? cut.h : L{};
}

template <class Scalar>
void PriorLanes<Scalar>::inputs_at(const Cut& cut, int time, int piece, double c, L* u) const {
  const L part = in_lanes<L>(piece + c) / cut.pieces, rest = in_lanes<L>(1.0) - part;
  for (int j = 0; j < setting_.inputs; ++j) {
    // In w the readings begin at row 2 n_y. The outputs are the first readings; the inputs follow at row 3 n_y.
    const int row = 3 * setting_.ny() + j;
    u[j] = rest * reading(row, setting_.commands ? time : time - 1) + part * reading(row, time);
  }
}

template <class Scalar>
void PriorLanes<Scalar>::predict(L* x, int time, Sample& sample) {
  sample.cut = cut(time);
  const auto most = static_cast<std::size_t>(sample.cut.most), carried = static_cast<std::size_t>(setting_.carried());
  if (sample.pieces.size() < most) {
    const std::vector<L> stages(static_cast<std::size_t>(equations_.step_size())), reached(carried);
    sample.pieces.resize(most, {stages, reached});
  }
  for (int i = 0; i < sample.cut.most; ++i) {
    Piece& now = sample.pieces[static_cast<std::size_t>(i)];
    equations_.step(
        x, step_of(sample.cut, i), [&](double c, L* u) { inputs_at(sample.cut, time, i, c, u); }, now.stages.data());
    for (std::size_t r = 0; r < carried; ++r) {
      now.reached[r] = x[r];
      x[r] = kept_within(x[r], setting_.low[r], setting_.high[r]);
    }
  }
}

/// Replaces the cotangent of the prior of a sample by the cotangent of [x; p] at the previous sample.
template <class Scalar>
void PriorLanes<Scalar>::predict_back(const Sample& sample, L* cotangent) {
  for (int i = sample.cut.most; i-- > 0;) {
    const Piece& piece = sample.pieces[static_cast<std::size_t>(i)];
    for (int r = 0; r < setting_.carried(); ++r)
      cotangent[r] = within(piece.reached[static_cast<std::size_t>(r)], r) ? cotangent[r] : L{};
    equations_.step_back(piece.stages.data(), step_of(sample.cut, i), cotangent);
  }
}

/// Writes the entries of w that do not come from the units: the innovation, the readings and the prior.
template <class Scalar>
void PriorLanes<Scalar>::make_readings(int time) {
  const int nx = setting_.nx(), ny = setting_.ny();
  for (int r = 0; r < setting_.readings; ++r)
    std::copy_n(given_ + (static_cast<std::ptrdiff_t>(r) * run_.length + time) * kGroup, kGroup, w(2 * ny + r, time));
  Sample& sample = this->sample(time);
  sample.output.resize(static_cast<std::size_t>(equations_.output_size()));
  L* const prior = sample.output.data();
  for (int i = 0; i < setting_.carried(); ++i)
    prior[i] = time == 0 ? in_lanes<L>(setting_.start[static_cast<std::size_t>(i)]) : simd::load<L>(x(i, time - 1));
  if (time > 0) predict(prior, time, sample);
  for (int i = 0; i < nx; ++i) simd::store(w(prior_row() + i, time), prior[i]);
  for (int j = 0; j < setting_.inputs; ++j) prior[setting_.carried() + j] = reading(3 * ny + j, time);
  equations_.output(prior);
  for (int j = 0; j < ny; ++j) {
    const auto row = static_cast<std::size_t>(j);
    const L nu = arrived(j, time) * (reading(2 * ny + j, time) - equations_.output(prior, j));
    simd::store(w(j, time), nu / (in_lanes<L>(setting_.fine[row]) + magnitude_of(nu)));
    simd::store(w(ny + j, time), nu / (in_lanes<L>(setting_.coarse[row]) + magnitude_of(nu)));
  }
}

template <class Scalar>
void PriorLanes<Scalar>::read(int time) {
  first_sample_ = time;
  make_readings(time);
}

template <class Scalar>
auto PriorLanes<Scalar>::noise(int correction) const -> L {
  if (setting_.units == 0) return in_lanes<L>(1.0);
  return exponential_of(kept_within(row_of<L>(gain_, correction), -kFarthestNoise, kFarthestNoise));
}

/// Writes the cotangent of the correction that sets a variance = constant * noise(correction), from the cotangent of
/// this variance.
template <class Scalar>
void PriorLanes<Scalar>::noise_back(int correction, const L& variance, const L& to_variance) {
  const auto inside = magnitude_of(row_of<L>(gain_, correction)) < in_lanes<L>(kFarthestNoise);
  set_row(to_gain_, correction, inside ? to_variance * variance * scale(correction) : L{});
}

/// Computes the corrections (gain_) from [m; w], the measurement update (measured_), and x_, the corrected prior before
/// it is clamped to the range.
template <class Scalar>
void PriorLanes<Scalar>::correct(const Scalar* in, int time) {
  const int first = 3 * setting_.units, nx = setting_.nx(), ny = setting_.ny();
  product<Scalar>(units_.weights(first), setting_.corrections(), units_.columns(), units_.bias(first), in,
                  gain_.data());
  for (int r = 0; r < setting_.corrections(); ++r) set_row(gain_, r, row_of<L>(gain_, r) * scale(r));
  const L* const prior = sample(time).output.data();
  std::copy_n(prior + nx, measured_.p.size(), measured_.p.begin());
  for (int j = 0; j < ny; ++j) {
    const auto row = static_cast<std::size_t>(j);
    for (int i = 0; i < nx; ++i)
      measured_.slopes[static_cast<std::size_t>(j * nx + i)] = equations_.slope(prior, j, i, ny);
    measured_.arrived[row] = arrived(j, time);
    measured_.innovations[row] = measured_.arrived[row] * (reading(2 * ny + j, time) - equations_.output(prior, j));
    measured_.r[row] = in_lanes<L>(setting_.output_noise[row]) * noise(noise_row() + nx + j);
  }
  for (int i = 0; i < nx; ++i) {
    const auto row = static_cast<std::size_t>(i);
    measured_.q[row] = in_lanes<L>(setting_.state_noise[row]) * noise(noise_row() + i) * periods(time);
  }
  update_.forward(measured_);
  for (int i = 0; i < nx; ++i) {
    const auto row = static_cast<std::size_t>(i);
    x_[row] = prior[i] + measured_.change[row];
    if (setting_.units == 0) continue;
    L learned = row_of<L>(gain_, nx * ny + i);
    for (int j = 0; j < ny; ++j) learned += row_of<L>(gain_, i * ny + j) * reading(ny + j, time);
    x_[row] += learned;
  }
  std::copy(measured_.p.begin(), measured_.p.end(), x_.begin() + nx);
}

template <class Scalar>
void PriorLanes<Scalar>::stepped(int time, const Scalar* in) {
  correct(in, time);
  for (int i = 0; i < setting_.carried(); ++i) {
    const auto row = static_cast<std::size_t>(i);
    simd::store(x(i, time), kept_within(x_[row], setting_.low[row], setting_.high[row]));
  }
}

template <class Scalar>
void PriorLanes<Scalar>::repeat(int from, int count) {
  samples_.resize(std::max(samples_.size(), static_cast<std::size_t>(count)));
  first_sample_ = from;
  for (int k = from; k < from + count; ++k) make_readings(k);
}

template <class Scalar>
void PriorLanes<Scalar>::forward(const GatedRun<Scalar>& run) {
  begin(run);
  units_.forward(run_, this);
}

template <class Scalar>
void PriorLanes<Scalar>::backward(const GatedRun<Scalar>& run, std::vector<double>& gradient) {
  if (parameters() == 0) return;
  begin(run);
  std::fill(to_x_.begin(), to_x_.end(), L{});
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

/// Propagates dl/d[x; p] of a sample back to the weights of the correction and to its inputs. A gradient above 1000 per
/// deviation of a state shows that the filter has lost the state. Then the gradient is set to 0, so that only later
/// samples of the run contribute.
template <class Scalar>
void PriorLanes<Scalar>::pull_back(int time, const Scalar* in, Scalar* to_z) {
  constexpr Scalar kLost = Scalar(1000), kFinite = Scalar(1e6);
  const int nx = setting_.nx(), ny = setting_.ny(), rows = setting_.corrections(), columns = units_.columns();
  correct(in, time);
  for (int i = 0; i < setting_.carried(); ++i) {
    const auto row = static_cast<std::size_t>(i);
    const Scalar* own =
        run_.cotangent + (static_cast<std::ptrdiff_t>(setting_.units + i) * run_.length + time) * kGroup;
    const L to = to_x_[row] + simd::load<L>(own);
    const L found = magnitude_of(to) * unit_[row] < kLost ? to : L{};
    to_x_[row] = within(x_[row], i) ? found : L{};
  }
  std::fill(to_squashed_.begin(), to_squashed_.end(), L{});
  for (int i = 0; i < nx; ++i) {
    const L to = to_x_[static_cast<std::size_t>(i)];
    set_row(to_gain_, nx * ny + i, to * scale(nx * ny + i));
    for (int j = 0; j < ny; ++j) {
      set_row(to_gain_, i * ny + j, to * reading(ny + j, time) * scale(i * ny + j));
      to_squashed_[static_cast<std::size_t>(j)] += to * row_of<L>(gain_, i * ny + j);
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
  for (int r = 0; r < rows; ++r) {
    const L to = row_of<L>(to_gain_, r), finite = magnitude_of(to) < kFinite ? to : L{};
    set_row(to_gain_, r, finite);
    set_row(bias_gradient_, r, row_of<L>(bias_gradient_, r) + finite);
  }
  Products<Scalar, kGroup>::outer_product(to_gain_.data(), rows, in, columns, gradient_.data());
  product<Scalar>(correction_transposed_.data(), columns, rows, nullptr, to_gain_.data(), to_in_.data());
  for (int r = 0; r < setting_.units; ++r) {
    Scalar* const to = to_z + lane(r, 0);
    simd::store(to, simd::load<L>(to) + row_of<L>(to_in_, r));
  }
}

/// Computes dl/d[x; p] of the previous sample from the cotangents of the units' inputs and to_x_.
template <class Scalar>
void PriorLanes<Scalar>::take(int time, const Scalar* to_readings) {
  const int nx = setting_.nx(), ny = setting_.ny();
  if (time == 0) return;
  const auto to_w = [&](int row) {
    const L all = simd::load<L>(to_readings + lane(row, 0)) + row_of<L>(to_in_, setting_.units + row);
    return all / in_lanes<L>(setting_.read.scale[static_cast<std::size_t>(row)]);
  };
  for (int i = 0; i < nx; ++i) to_x_[static_cast<std::size_t>(i)] += to_w(prior_row() + i);
  for (int j = 0; j < ny; ++j) {
    const auto row = static_cast<std::size_t>(j);
    // s = nu / (c + |nu|): ds/dnu = c / (c + |nu|)^2, and 1 - |s| = c / (c + |nu|)
    const auto slope = [](L s, double c) {
      const L rest = in_lanes<L>(1.0) - magnitude_of(s);
      return rest * rest / in_lanes<L>(c);
    };
    to_expected_[row] =
        arrived(j, time) * (-(to_squashed_[row] + to_w(ny + j)) * slope(reading(ny + j, time), setting_.coarse[row]) -
                            to_w(j) * slope(reading(j, time), setting_.fine[row]) - to_measured_.innovations[row]);
  }
  const auto to_output = [&](int row) {
    return row < ny ? to_expected_[static_cast<std::size_t>(row)]
                    : to_measured_.slopes[static_cast<std::size_t>(row - ny)];
  };
  const Sample& sample = this->sample(time);
  equations_.output_back(sample.output.data(), to_output, to_x_.data());
  predict_back(sample, to_x_.data());
}

template class PriorLanes<float>;
template class PriorLanes<double>;

}  // namespace nlo::trainer
