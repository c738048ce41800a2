// SPDX-License-Identifier: MIT
#include "codegen/readback/folding.h"

#include <cmath>
#include <complex>
#include <limits>
#include <string>

#include "codegen/base/fail.h"

namespace nlo::codegen {
namespace {

using Eigen::Index;
using Real = long double;
using ComplexReal = std::complex<Real>;

/// Roundings that double may have taken, and those of a series of some thirty terms.
constexpr Real kRoundings = 64.0L * static_cast<Real>(std::numeric_limits<double>::epsilon());

/// A sum, and that of its terms' magnitudes: what its rounding goes by.
struct Sum {
  Real value = 0.0L, size = 0.0L;
  void add(Real term) {
    value += term;
    size += std::abs(term);
  }
};

class Folding {
 public:
  explicit Folding(WeightType weights)
      : half_unit_(weights == WeightType::kFull       ? 0.0L
                   : weights == WeightType::kBfloat16 ? 0x1p-8L
                                                      : 0x1p-11L) {}

  void network(const Named<const Network>& named, const FoldedNetwork& folded) const {
    const Network& n = *named.network;
    const std::string& name = named.field;
    const std::size_t last = n.layers.size() - 1;
    if (folded.layers.size() != n.layers.size())
      fail("{} has {} layers when folded, and the model {}", name, folded.layers.size(), n.layers.size());
    for (std::size_t l = 0; l <= last; ++l) {
      const DenseLayer &layer = n.layers[l], &got = folded.layers[l];
      const Index inputs = l == 0 ? named.reads : layer.weights.cols();
      if (got.weights.rows() != layer.weights.rows() || got.weights.cols() != inputs ||
          got.bias.size() != layer.bias.size())
        fail("{}.layers[{}] is {} x {} when folded, and the model's {} x {}", name, l, got.weights.rows(),
             got.weights.cols(), layer.weights.rows(), inputs);
      for (Index o = 0; o < layer.weights.rows(); ++o) {
        const Real scale = l == last ? static_cast<Real>(n.output_scale(o)) : 1.0L;
        Sum bias;
        bias.add(scale * static_cast<Real>(layer.bias(o)));
        if (l == last) bias.add(static_cast<Real>(n.output_mean(o)));
        if (l == 0) add_offset(n, layer.weights, o, scale, bias);
        if (l == last && n.skip.size() != 0) add_offset(n, n.skip, o, scale, bias);
        compare(name, l, "bias", o, -1, got.bias(o), bias, 0.0L);
        for (Index i = 0; i < inputs; ++i) {
          Sum weight;
          if (l == 0) {
            add_gain(n, layer.weights, o, i, scale, weight);
          } else {
            weight.add(scale * static_cast<Real>(layer.weights(o, i)));
          }
          if (last == 0 && n.skip.size() != 0) add_gain(n, n.skip, o, i, scale, weight);
          compare(name, l, "weights", o, i, got.weights(o, i), weight, half_unit_);
        }
      }
    }
    linear_path(n, name, named.reads, folded.linear_path, last > 0);
  }

  /// z over one sample period, and S: D S + F = 0.
  void latent(const Model& m, const FoldedModel& folded) const {
    const LinearLatent& latent = *linear_latent(m);
    for (Index r = 0; r < m.nz(); ++r) {
      const bool pair = r < 2 * latent.pairs;
      const auto complex = [&](double real, double imaginary) {
        return ComplexReal(static_cast<Real>(real), pair ? static_cast<Real>(imaginary) : 0.0L);
      };
      const Index next = pair ? r + 1 : r;
      const ComplexReal lambda = complex(latent.eigenvalues(r), latent.eigenvalues(next));
      const Step step(m.hold, lambda, static_cast<Real>(m.sample_period_s));
      const auto of = [&](const Eigen::MatrixXd& values, Index column) {
        return complex(values(r, column), values(next, column));
      };
      compare_complex("A - I", r, of(folded.step.a_minus_1, 0), step.a_minus_1, step.a_minus_1);
      for (Index j = 0; j < m.nr(); ++j) {
        const ComplexReal f = of(latent.output_injection, j);
        compare_complex("B0", r, of(folded.step.b0, j), step.b0 * f, step.b0 * f);
        compare_complex("B1", r, of(folded.step.b1, j), step.b1 * f, step.b0 * f);
        compare_complex("S", r, of(folded.steady_gain, j), -f / lambda, f / lambda);
      }
      if (pair) ++r;
    }
  }

 private:
  /// Of z' = lambda z + y, y a ramp or constant over h.
  struct Step {
    ComplexReal a_minus_1, b0, b1;

    Step(Hold hold, ComplexReal lambda, Real h) {
      if (hold == Hold::kRk4) {
        a_minus_1 = runge_kutta(lambda, h, 1.0L, 0.0L, 0.0L) - 1.0L;
        b0 = runge_kutta(lambda, h, 0.0L, 1.0L, 0.0L);
        b1 = runge_kutta(lambda, h, 0.0L, 0.0L, 1.0L);
        return;
      }
      const ComplexReal w = lambda * h, phi1 = phi(1, w), phi2 = phi(2, w);
      a_minus_1 = w * phi1;
      b0 = hold == Hold::kZeroOrder ? h * phi1 : h * (phi1 - phi2);
      b1 = hold == Hold::kZeroOrder ? ComplexReal() : h * phi2;
    }

    /// phi_k(w) = sum over n of w^n / (n + k)!: far from 0 by the exponential itself.
    static ComplexReal phi(int k, ComplexReal w) {
      if (std::abs(w) > 1.0L) {
        const ComplexReal phi1 = (std::exp(w) - 1.0L) / w;
        return k == 1 ? phi1 : (phi1 - 1.0L) / w;
      }
      ComplexReal term = k == 1 ? 1.0L : 0.5L, sum = term;
      for (int n = 1; n < 30; ++n) {
        term *= w / static_cast<Real>(n + k);
        sum += term;
      }
      return sum;
    }

    static ComplexReal runge_kutta(ComplexReal lambda, Real h, ComplexReal z, Real y0, Real y1) {
      const auto slope = [&](ComplexReal at, Real part) { return lambda * at + (y0 + (y1 - y0) * part); };
      const ComplexReal k1 = slope(z, 0.0L), k2 = slope(z + h / 2.0L * k1, 0.5L), k3 = slope(z + h / 2.0L * k2, 0.5L),
                        k4 = slope(z + h * k3, 1.0L);
      return z + h / 6.0L * (k1 + 2.0L * k2 + 2.0L * k3 + k4);
    }
  };

  static void add_gain(const Network& n, const Eigen::MatrixXd& weights, Index o, Index i, Real scale, Sum& to) {
    for (Index k = 0; k < n.features.rows(); ++k)
      to.add(scale * static_cast<Real>(weights(o, k)) * static_cast<Real>(n.features(k, i)) /
             static_cast<Real>(n.feature_scale(k)));
  }
  static void add_offset(const Network& n, const Eigen::MatrixXd& weights, Index o, Real scale, Sum& to) {
    for (Index k = 0; k < n.features.rows(); ++k)
      to.add(-scale * static_cast<Real>(weights(o, k)) * static_cast<Real>(n.feature_mean(k)) /
             static_cast<Real>(n.feature_scale(k)));
  }

  void linear_path(const Network& n, const std::string& name, Index inputs, const Eigen::MatrixXd& got,
                   bool has_hidden) const {
    const bool there = n.skip.size() != 0 && has_hidden;
    if ((got.size() != 0) != there || (there && (got.rows() != n.skip.rows() || got.cols() != inputs)))
      fail("{}.skip is {} x {} when folded", name, got.rows(), got.cols());
    for (Index o = 0; o < got.rows(); ++o)
      for (Index i = 0; i < got.cols(); ++i) {
        Sum sum;
        add_gain(n, n.skip, o, i, static_cast<Real>(n.output_scale(o)), sum);
        if (!(std::abs(static_cast<Real>(got(o, i)) - sum.value) <= kRoundings * sum.size))
          fail("{}.skip[{}][{}] is {} when folded, and by the model {}", name, o, i, got(o, i),
               static_cast<double>(sum.value));
      }
  }

  static void compare(const std::string& name, std::size_t layer, const char* part, Index o, Index i, double got,
                      const Sum& want, Real half_unit) {
    if (std::abs(static_cast<Real>(got) - want.value) <=
        kRoundings * want.size + half_unit * std::abs(want.value) + tiny(half_unit))
      return;
    const std::string column = i < 0 ? "" : fmt::format("[{}]", i);
    fail("{}.layers[{}].{}[{}]{} is {} when folded, and by the model {}", name, layer, part, o, column, got,
         static_cast<double>(want.value));
  }

  /// Numbers of 16 bits end at 2^-24.
  static Real tiny(Real half_unit) { return half_unit > 0.0L ? 0x1p-25L : 0.0L; }

  static void compare_complex(const char* what, Index r, ComplexReal got, ComplexReal want, ComplexReal size) {
    if (std::abs(got - want) <= kRoundings * (std::abs(want) + std::abs(size))) return;
    fail("{}[{}] is {} + {}i when discretised, and by the model {} + {}i", what, r, static_cast<double>(got.real()),
         static_cast<double>(got.imag()), static_cast<double>(want.real()), static_cast<double>(want.imag()));
  }

  Real half_unit_;
};

}  // namespace

void check_folding(const Model& m, const FoldedModel& folded, WeightType weights) {
  const Folding folding(weights);
  for (const Named<const Network>& named : networks(m)) folding.network(named, folded.network(named.field));
  if (linear_latent(m) != nullptr) folding.latent(m, folded);
}

}  // namespace nlo::codegen
