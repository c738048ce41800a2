// SPDX-License-Identifier: MIT
#include "trainer/gradients/sensitivity/linear_latent.h"

#include <cmath>

#include "nlo/kernels/lane_sum.h"
#include "nlo/kernels/simd.h"
#include "trainer/base/even_parts.h"
#include "trainer/gradients/sensitivity/dual.h"

namespace nlo::trainer {
namespace {

using P = simd::Pack<float, kGroup>;

std::complex<float> narrow(std::complex<double> c) {
  return {static_cast<float>(c.real()), static_cast<float>(c.imag())};
}
std::complex<double> value(const Complex<Dual>& c) {
  return {c.re.value, c.im.value};
}
std::complex<double> slope(const Complex<Dual>& c) {
  return {c.re.slope, c.im.slope};
}

std::complex<double> eigenvalue(const Mode& mode, const double* eigenvalues) {
  return {eigenvalues[mode.row], mode.pair ? eigenvalues[mode.row + 1] : 0.0};
}

/// Returns df/dlambda.
std::complex<double> injection_slope(Injection injection, const Mode& mode) {
  return injection == Injection::kUnitGain && mode.reading >= 0 ? -1.0 : 0.0;
}

}  // namespace

void eigenvalues_from_parameters(const LatentShape& shape, const float* parameters, double* eigenvalues) {
  for (const Mode& mode : shape.modes) {
    if (mode.reading < 0) continue;
    eigenvalues[mode.row] = -std::exp(static_cast<double>(parameters[mode.row]));
    if (mode.pair) eigenvalues[mode.row + 1] = std::exp(static_cast<double>(parameters[mode.row + 1]));
  }
}

std::vector<float> parameters_from_eigenvalues(const LatentShape& shape, const double* eigenvalues) {
  std::vector<float> parameters(static_cast<std::size_t>(shape.learned));
  for (int r = 0; r < shape.learned; ++r) {
    parameters[static_cast<std::size_t>(r)] = static_cast<float>(std::log(std::abs(eigenvalues[r])));
  }
  return parameters;
}

std::complex<double> injection_of(Injection injection, const Mode& mode, std::complex<double> lambda) {
  if (mode.reading < 0) return 0.0;
  if (injection == Injection::kUnitGain) return -lambda;
  return mode.pair ? std::complex<double>{1.0, 1.0} : std::complex<double>{1.0, 0.0};
}

void Coefficients::compute(const LatentShape& shape, const double* eigenvalues, const std::vector<double>& steps_s) {
  steps_ = steps_s.size();
  table_.resize(shape.modes.size() * steps_);
  start_.resize(shape.modes.size());
  start_slope_.resize(shape.modes.size());
  for (std::size_t m = 0; m < shape.modes.size(); ++m) {
    const Mode& mode = shape.modes[m];
    const std::complex<double> lambda = eigenvalue(mode, eigenvalues);
    const std::complex<double> f = injection_of(shape.injection, mode, lambda);
    const std::complex<double> df = injection_slope(shape.injection, mode);
    start_[m] = shape.starts_steady ? narrow(-f / lambda) : 0.0F;
    start_slope_[m] = shape.starts_steady ? narrow(f / (lambda * lambda) - df / lambda) : 0.0F;
    for (std::size_t s = 0; s < steps_; ++s) {
      const auto step =
          discretise(shape.hold, Complex<Dual>{Dual(lambda.real(), 1.0), Dual(lambda.imag())}, Dual(steps_s[s]));
      ModeCoefficients& c = table_[m * steps_ + s];
      c.a_minus_1 = narrow(value(step.a_minus_1));
      c.b0 = narrow(value(step.b0) * f);
      c.b1 = narrow(value(step.b1) * f);
      c.da = narrow(slope(step.a_minus_1));
      c.db0 = narrow(slope(step.b0) * f + value(step.b0) * df);
      c.db1 = narrow(slope(step.b1) * f + value(step.b1) * df);
    }
  }
}

namespace {

struct ComplexPack {
  P re, im;
};

/// Returns a coefficient for eight lanes: the same for all if sampling is uniform, otherwise by the step of each lane.
template <bool kUniform>
NLO_INLINE ComplexPack pick(const ModeCoefficients* table, std::complex<float> ModeCoefficients::*member,
                            const int* step_of) {
  if constexpr (kUniform) {
    return {simd::broadcast<P>((table->*member).real()), simd::broadcast<P>((table->*member).imag())};
  } else {
    float re[kGroup];
    float im[kGroup];
    for (int l = 0; l < kGroup; ++l) {
      const std::complex<float> c = table[step_of[l]].*member;
      re[l] = c.real();
      im[l] = c.imag();
    }
    return {simd::load<P>(re), simd::load<P>(im)};
  }
}

/// Prevents the compiler from fusing a product with an addition. Otherwise the result would depend on the number of
/// modes that are compiled together.
template <class Value>
NLO_INLINE Value rounded(Value product) {
  if constexpr (sizeof(Value) > simd::kVectorBytes) {
    return product;  // fills two registers; simd::rounded() takes one
  } else {
    return simd::rounded(product);
  }
}

/// One mode during a pass through a group: coefficients, input, rows of z and of dl/dz. Only pairs use the fields _im.
struct ModeRun {
  const ModeCoefficients* table;
  std::complex<float> start, start_slope;
  const float* y;
  int ahead;
  float *z_re, *z_im;
  const float *g_re, *g_im;
  int row;
};

/// Modes of one kind that are computed together: the steps of one mode depend on each other, those of several do not.
constexpr int kTogether = 4;

/// continues: z of sample 0 is given.
template <bool kPair, bool kUniform, int kModes>
void filter_modes(const ModeRun* modes, const int* step_of, int length, bool continues) {
  struct Coefficient {
    ComplexPack a, b0, b1;
  };
  const auto coefficient = [](const ModeRun& mode, const int* steps) NLO_INLINE_LAMBDA {
    return Coefficient{pick<kUniform>(mode.table, &ModeCoefficients::a_minus_1, steps),
                       pick<kUniform>(mode.table, &ModeCoefficients::b0, steps),
                       pick<kUniform>(mode.table, &ModeCoefficients::b1, steps)};
  };
  P re[kModes], im[kModes];
  Coefficient same[kModes];  // for uniform sampling
  for (int m = 0; m < kModes; ++m) {
    const ModeRun& mode = modes[m];
    const P y0 = simd::load<P>(mode.y);
    re[m] = simd::broadcast<P>(mode.start.real()) * y0;
    im[m] = simd::broadcast<P>(mode.start.imag()) * y0;
    if (continues) {
      re[m] = simd::load<P>(mode.z_re);
      if constexpr (kPair) im[m] = simd::load<P>(mode.z_im);
    }
    simd::store(mode.z_re, re[m]);
    if constexpr (kPair) simd::store(mode.z_im, im[m]);
    if constexpr (kUniform) same[m] = coefficient(mode, nullptr);
  }
  for (int t = 0; t + 1 < length; ++t) {
    NLO_UNROLL
    for (int m = 0; m < kModes; ++m) {
      const ModeRun& mode = modes[m];
      const auto [a, b0, b1] = kUniform ? same[m] : coefficient(mode, step_of + t * kGroup);
      const P now = simd::load<P>(mode.y + (t + mode.ahead) * kGroup);
      const P next = simd::load<P>(mode.y + (t + 1) * kGroup);
      if constexpr (kPair) {
        const P change_re = a.re * re[m] - rounded(a.im * im[m]) + rounded(b0.re * now + rounded(b1.re * next));
        const P change_im = a.im * re[m] + rounded(a.re * im[m]) + rounded(b0.im * now + rounded(b1.im * next));
        re[m] += change_re;
        im[m] += change_im;
        simd::store(mode.z_im + (t + 1) * kGroup, im[m]);
      } else {
        re[m] += a.re * re[m] + (b0.re * now + rounded(b1.re * next));
      }
      simd::store(mode.z_re + (t + 1) * kGroup, re[m]);
    }
  }
}

/// Writes the complex derivatives of l with respect to lambda, dl = Re(result dlambda), summed over lanes and time.
template <bool kPair, bool kUniform, int kModes>
void adjoint_modes(const ModeRun* modes, const int* step_of, int length, std::complex<double>* slopes) {
  struct Coefficient {
    ComplexPack a, da, db0, db1;
  };
  const auto coefficient = [](const ModeRun& mode, const int* steps) NLO_INLINE_LAMBDA {
    return Coefficient{pick<kUniform>(mode.table, &ModeCoefficients::a_minus_1, steps),
                       pick<kUniform>(mode.table, &ModeCoefficients::da, steps),
                       pick<kUniform>(mode.table, &ModeCoefficients::db0, steps),
                       pick<kUniform>(mode.table, &ModeCoefficients::db1, steps)};
  };
  const std::ptrdiff_t last = static_cast<std::ptrdiff_t>(length - 1) * kGroup;
  P p_re[kModes], p_im[kModes] = {}, sum_re[kModes] = {}, sum_im[kModes] = {};
  Coefficient same[kModes];
  for (int m = 0; m < kModes; ++m) {
    p_re[m] = simd::load<P>(modes[m].g_re + last);
    if constexpr (kPair) p_im[m] = simd::load<P>(modes[m].g_im + last);
    if constexpr (kUniform) same[m] = coefficient(modes[m], nullptr);
  }
  // Accumulates conj(p) w, with w = a' z + b0' y_k + b1' y_{k+1}.
  const auto accumulate = [&](int m, P w_re, P w_im) NLO_INLINE_LAMBDA {
    sum_re[m] += p_re[m] * w_re + rounded(p_im[m] * w_im);
    sum_im[m] += p_re[m] * w_im - rounded(p_im[m] * w_re);
  };
  for (int t = length - 2; t >= 0; --t) {
    NLO_UNROLL
    for (int m = 0; m < kModes; ++m) {
      const ModeRun& mode = modes[m];
      const auto [a, da, db0, db1] = kUniform ? same[m] : coefficient(mode, step_of + t * kGroup);
      const P now = simd::load<P>(mode.y + (t + mode.ahead) * kGroup);
      const P next = simd::load<P>(mode.y + (t + 1) * kGroup);
      const P z = simd::load<P>(mode.z_re + t * kGroup);
      if constexpr (kPair) {
        const P w = simd::load<P>(mode.z_im + t * kGroup);
        accumulate(m, da.re * z - rounded(da.im * w) + db0.re * now + db1.re * next,
                   da.im * z + rounded(da.re * w) + db0.im * now + db1.im * next);
        const P back_re = a.re * p_re[m] + rounded(a.im * p_im[m]);
        const P back_im = a.re * p_im[m] - rounded(a.im * p_re[m]);
        p_re[m] += back_re + simd::load<P>(mode.g_re + t * kGroup);
        p_im[m] += back_im + simd::load<P>(mode.g_im + t * kGroup);
      } else {
        accumulate(m, da.re * z + rounded(db0.re * now) + db1.re * next, P{});
        p_re[m] += a.re * p_re[m] + simd::load<P>(mode.g_re + t * kGroup);
      }
    }
  }
  for (int m = 0; m < kModes; ++m) {
    const P y0 = simd::load<P>(modes[m].y);
    const std::complex<float> slope = modes[m].start_slope;
    accumulate(m, simd::broadcast<P>(slope.real()) * y0, simd::broadcast<P>(slope.imag()) * y0);
    slopes[m] = {static_cast<double>(simd::sum<float>(sum_re[m])), static_cast<double>(simd::sum<float>(sum_im[m]))};
  }
}

/// Returns the modes of one kind that a reading drives.
std::vector<ModeRun> runs_of(bool pair, const LatentShape& shape, const Coefficients& coefficients,
                             SegmentGroup& group) {
  std::vector<ModeRun> runs;
  for (std::size_t m = 0; m < shape.modes.size(); ++m) {
    const Mode& mode = shape.modes[m];
    if (mode.reading < 0 || mode.pair != pair) continue;
    const std::size_t re = group.at(mode.row, 0), im = group.at(mode.row + (pair ? 1 : 0), 0);
    const float* g = group.cotangent.data();
    runs.push_back({.table = coefficients.mode(m),
                    .start = coefficients.start(m),
                    .start_slope = coefficients.start_slope(m),
                    .y = group.readings.data() + group.at(mode.reading, 0),
                    .ahead = shape.ahead(mode.reading),
                    .z_re = group.latent.data() + re,
                    .z_im = group.latent.data() + im,
                    .g_re = group.cotangent.empty() ? nullptr : g + re,
                    .g_im = group.cotangent.empty() ? nullptr : g + im,
                    .row = mode.row});
  }
  return runs;
}

template <bool kUniform>
void filter_clock(const ModeCoefficients* table, const int* step_of, int length, bool continues, float* z_re) {
  P z = continues ? simd::load<P>(z_re) : simd::broadcast<P>(1.0F);  // z_0 = 1, and there is no input
  for (int t = 0; t < length; ++t) {
    simd::store(z_re + t * kGroup, z);
    z += z * pick<kUniform>(table, &ModeCoefficients::a_minus_1, kUniform ? nullptr : step_of + t * kGroup).re;
  }
}

template <bool kUniform>
void filter_as(const LatentShape& shape, const Coefficients& coefficients, SegmentGroup& group) {
  const auto filter_all = [&]<bool kPair>(std::bool_constant<kPair>) {
    const std::vector<ModeRun> runs = runs_of(kPair, shape, coefficients, group);
    in_even_parts<kTogether>(static_cast<int>(runs.size()), [&](auto count, int first) {
      filter_modes<kPair, kUniform, count()>(runs.data() + first, group.step_of.data(), group.length, group.continues);
    });
  };
  filter_all(std::true_type());
  filter_all(std::false_type());
  for (std::size_t m = 0; m < shape.modes.size(); ++m) {
    if (shape.modes[m].reading >= 0) continue;
    filter_clock<kUniform>(coefficients.mode(m), group.step_of.data(), group.length, group.continues,
                           group.latent.data() + group.at(shape.modes[m].row, 0));
  }
}

template <bool kUniform>
void adjoint_as(const LatentShape& shape, const Coefficients& coefficients, const double* eigenvalues,
                SegmentGroup& group) {
  group.gradient.assign(static_cast<std::size_t>(shape.learned), 0.0);
  const auto pull_back_all = [&]<bool kPair>(std::bool_constant<kPair>) {
    const std::vector<ModeRun> runs = runs_of(kPair, shape, coefficients, group);
    in_even_parts<kTogether>(static_cast<int>(runs.size()), [&](auto count, int first) {
      std::complex<double> slopes[count()];
      adjoint_modes<kPair, kUniform, count()>(runs.data() + first, group.step_of.data(), group.length, slopes);
      // lambda = -exp(p) + i exp(q): dl/dp = Re(d) re, dl/dq = -Im(d) im
      for (int m = 0; m < count(); ++m) {
        const auto row = static_cast<std::size_t>(runs[static_cast<std::size_t>(first + m)].row);
        group.gradient[row] = slopes[m].real() * eigenvalues[row];
        if (kPair) group.gradient[row + 1] = -slopes[m].imag() * eigenvalues[row + 1];
      }
    });
  };
  pull_back_all(std::true_type());
  pull_back_all(std::false_type());
}

}  // namespace

void filter(const LatentShape& shape, const Coefficients& coefficients, SegmentGroup& group) {
  group.step_of.empty() ? filter_as<true>(shape, coefficients, group) : filter_as<false>(shape, coefficients, group);
}

void adjoint_filter(const LatentShape& shape, const Coefficients& coefficients, const double* eigenvalues,
                    SegmentGroup& group) {
  group.step_of.empty() ? adjoint_as<true>(shape, coefficients, eigenvalues, group)
                        : adjoint_as<false>(shape, coefficients, eigenvalues, group);
}

}  // namespace nlo::trainer
