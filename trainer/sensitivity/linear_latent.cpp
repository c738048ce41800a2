// SPDX-License-Identifier: MIT
#include "trainer/sensitivity/linear_latent.h"

#include <cmath>

#include "nlo/kernels/lane_sum.h"
#include "nlo/kernels/simd.h"
#include "trainer/sensitivity/dual.h"

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

/// df/dlambda.
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

/// A coefficient for eight lanes: the same for all when sampling is uniform, else each lane's own step.
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

template <bool kPair, bool kUniform>
void filter_mode(const ModeCoefficients* table, std::complex<float> start, const float* y, int ahead,
                 const int* step_of, int length, float* z_re, float* z_im) {
  const P y0 = simd::load<P>(y);
  P re = simd::broadcast<P>(start.real()) * y0;
  P im = simd::broadcast<P>(start.imag()) * y0;
  simd::store(z_re, re);
  if constexpr (kPair) simd::store(z_im, im);
  for (int t = 0; t + 1 < length; ++t) {
    const int* steps = kUniform ? nullptr : step_of + t * kGroup;
    const ComplexPack a = pick<kUniform>(table, &ModeCoefficients::a_minus_1, steps);
    const ComplexPack b0 = pick<kUniform>(table, &ModeCoefficients::b0, steps);
    const ComplexPack b1 = pick<kUniform>(table, &ModeCoefficients::b1, steps);
    const P now = simd::load<P>(y + (t + ahead) * kGroup);
    const P next = simd::load<P>(y + (t + 1) * kGroup);
    if constexpr (kPair) {
      const P change_re = a.re * re - a.im * im + (b0.re * now + b1.re * next);
      const P change_im = a.im * re + a.re * im + (b0.im * now + b1.im * next);
      re += change_re;
      im += change_im;
      simd::store(z_im + (t + 1) * kGroup, im);
    } else {
      re += a.re * re + (b0.re * now + b1.re * next);
    }
    simd::store(z_re + (t + 1) * kGroup, re);
  }
}

/// Returns the complex derivative of l with respect to lambda, dl = Re(result dlambda), summed over lanes and time.
template <bool kPair, bool kUniform>
std::complex<double> adjoint_mode(const ModeCoefficients* table, std::complex<float> start_slope, const float* y,
                                  int ahead, const int* step_of, int length, const float* z_re, const float* z_im,
                                  const float* g_re, const float* g_im) {
  const std::ptrdiff_t last = static_cast<std::ptrdiff_t>(length - 1) * kGroup;
  P p_re = simd::load<P>(g_re + last);
  P p_im{};
  if constexpr (kPair) p_im = simd::load<P>(g_im + last);
  P sum_re{};
  P sum_im{};
  // conj(p) w accumulated, w = a' z + b0' y_k + b1' y_{k+1}
  const auto accumulate = [&](P w_re, P w_im) NLO_INLINE_LAMBDA {
    sum_re += p_re * w_re + p_im * w_im;
    sum_im += p_re * w_im - p_im * w_re;
  };
  for (int t = length - 2; t >= 0; --t) {
    const int* steps = kUniform ? nullptr : step_of + t * kGroup;
    const ComplexPack a = pick<kUniform>(table, &ModeCoefficients::a_minus_1, steps);
    const ComplexPack da = pick<kUniform>(table, &ModeCoefficients::da, steps);
    const ComplexPack db0 = pick<kUniform>(table, &ModeCoefficients::db0, steps);
    const ComplexPack db1 = pick<kUniform>(table, &ModeCoefficients::db1, steps);
    const P now = simd::load<P>(y + (t + ahead) * kGroup);
    const P next = simd::load<P>(y + (t + 1) * kGroup);
    const P z = simd::load<P>(z_re + t * kGroup);
    if constexpr (kPair) {
      const P w = simd::load<P>(z_im + t * kGroup);
      accumulate(da.re * z - da.im * w + db0.re * now + db1.re * next,
                 da.im * z + da.re * w + db0.im * now + db1.im * next);
      const P back_re = a.re * p_re + a.im * p_im;
      const P back_im = a.re * p_im - a.im * p_re;
      p_re += back_re + simd::load<P>(g_re + t * kGroup);
      p_im += back_im + simd::load<P>(g_im + t * kGroup);
    } else {
      accumulate(da.re * z + db0.re * now + db1.re * next, P{});
      p_re += a.re * p_re + simd::load<P>(g_re + t * kGroup);
    }
  }
  const P y0 = simd::load<P>(y);
  accumulate(simd::broadcast<P>(start_slope.real()) * y0, simd::broadcast<P>(start_slope.imag()) * y0);
  return {static_cast<double>(simd::sum<float>(sum_re)), static_cast<double>(simd::sum<float>(sum_im))};
}

template <bool kUniform>
void filter_as(const LatentShape& shape, const Coefficients& coefficients, SegmentGroup& group) {
  for (std::size_t m = 0; m < shape.modes.size(); ++m) {
    const Mode& mode = shape.modes[m];
    float* z_re = group.latent.data() + group.at(mode.row, 0);
    if (mode.reading < 0) {  // a clock: z_0 = 1 and nothing comes in
      const ModeCoefficients* table = coefficients.mode(m);
      P z = simd::broadcast<P>(1.0F);
      for (int t = 0; t < group.length; ++t) {
        simd::store(z_re + t * kGroup, z);
        z += z *
             pick<kUniform>(table, &ModeCoefficients::a_minus_1, kUniform ? nullptr : group.step_of.data() + t * kGroup)
                 .re;
      }
      continue;
    }
    float* z_im = z_re + group.at(1, 0);
    const float* y = group.readings.data() + group.at(mode.reading, 0);
    const auto run = mode.pair ? filter_mode<true, kUniform> : filter_mode<false, kUniform>;
    run(coefficients.mode(m), coefficients.start(m), y, shape.ahead(mode.reading), group.step_of.data(), group.length,
        z_re, z_im);
  }
}

template <bool kUniform>
void adjoint_as(const LatentShape& shape, const Coefficients& coefficients, const double* eigenvalues,
                SegmentGroup& group) {
  group.gradient.assign(static_cast<std::size_t>(shape.learned), 0.0);
  for (std::size_t m = 0; m < shape.modes.size(); ++m) {
    const Mode& mode = shape.modes[m];
    if (mode.reading < 0) continue;
    const std::size_t re = group.at(mode.row, 0);
    const std::size_t im = group.at(mode.row + (mode.pair ? 1 : 0), 0);
    const auto run = mode.pair ? adjoint_mode<true, kUniform> : adjoint_mode<false, kUniform>;
    const std::complex<double> d =
        run(coefficients.mode(m), coefficients.start_slope(m), group.readings.data() + group.at(mode.reading, 0),
            shape.ahead(mode.reading), group.step_of.data(), group.length, group.latent.data() + re,
            group.latent.data() + im, group.cotangent.data() + re, group.cotangent.data() + im);
    // lambda = -exp(p) + i exp(q): dl/dp = Re(d) re, dl/dq = -Im(d) im
    group.gradient[static_cast<std::size_t>(mode.row)] = d.real() * eigenvalues[mode.row];
    if (mode.pair) group.gradient[static_cast<std::size_t>(mode.row) + 1] = -d.imag() * eigenvalues[mode.row + 1];
  }
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
