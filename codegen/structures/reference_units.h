// SPDX-License-Identifier: MIT
// Gated units of several structures: a step of the units in the reference, and the checks of their layers.
#pragma once

#include <nlo/kernels/activation.h>

#include <algorithm>
#include <cmath>

#include "codegen/reference/dynamics.h"

namespace nlo::codegen {

/// Gated units of a gated observer (codegen/model/gated.h), with any readings beside z.
template <class Scalar>
class ReferenceUnits {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  static constexpr int kLongestGap = 1000;  ///< sample periods that a step may span, as in nlo/gated_observer.h

  ReferenceUnits(const Network& gates, const Network& candidate, Activations activations)
      : exact_(activations == Activations::kExact), gates_(gates), candidate_(candidate) {}

  /// Returns z after `periods` sample periods, with the readings at their end.
  Matrix stepped(const Matrix& z, const Matrix& readings, Scalar periods) const {
    const Pull pull = pulled(z, readings);
    const Matrix share = pull.exponent.unaryExpr([&](Scalar rate) { return -std::expm1(-periods * rate); });
    return z + share.cwiseProduct(pull.target - z);
  }

  /// Returns rate (target - z) per sample period.
  Matrix slope(const Matrix& z, const Matrix& readings) const {
    const Pull pull = pulled(z, readings);
    return pull.exponent.cwiseProduct(pull.target - z);
  }

 private:
  /// The target of z, and the exponent of the motion towards it over one sample period.
  struct Pull {
    Matrix exponent, target;
  };

  Pull pulled(const Matrix& z, const Matrix& y) const {
    const Matrix a = gates_(stacked<Scalar>(z, y));
    const Matrix reset = a.bottomRows(z.rows()).unaryExpr([this](Scalar v) { return (1 + tanh(v)) / 2; });
    const auto softplus = [](Scalar v) { return std::max(2 * v, Scalar(0)) + std::log1p(std::exp(-std::abs(2 * v))); };
    return {a.topRows(z.rows()).unaryExpr(softplus),
            candidate_(stacked<Scalar>(reset.cwiseProduct(z), y)).unaryExpr([this](Scalar v) { return tanh(v); })};
  }

  Scalar tanh(Scalar v) const { return exact_ ? std::tanh(v) : tanh_rational(v); }

  bool exact_;
  ReferenceNetwork<Scalar> gates_, candidate_;
};

/// Checks that a layer is single, has no linear path, and keeps its sums in float if its inputs stay within
/// +-`largest`.
void check_gate_layer(const Network& network, const Eigen::VectorXd& largest, int outputs, const char* field,
                      const char* meaning);

}  // namespace nlo::codegen
