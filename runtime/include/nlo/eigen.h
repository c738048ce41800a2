// SPDX-License-Identifier: MIT
// Views of the runtime's vectors for Eigen, without a copy. Optional: no other header of the runtime includes Eigen.
#pragma once

#include <Eigen/Core>

#include "nlo/vector.h"

namespace nlo::inline NLO_ISA {

/// Returns a view of the vector as an Eigen column vector.
template <class Scalar, int kN>
auto as_eigen(Vector<Scalar, kN>& v) {
  return Eigen::Map<Eigen::Matrix<Scalar, kN, 1>>(v.data());
}
template <class Scalar, int kN>
auto as_eigen(const Vector<Scalar, kN>& v) {
  return Eigen::Map<const Eigen::Matrix<Scalar, kN, 1>>(v.data());
}

/// Returns a copy of a fixed-size Eigen column vector as a vector of the runtime.
template <class Derived>
auto from_eigen(const Eigen::MatrixBase<Derived>& v) {
  static_assert(Derived::ColsAtCompileTime == 1 && Derived::RowsAtCompileTime > 0, "a fixed-size column vector");
  Vector<typename Derived::Scalar, Derived::RowsAtCompileTime> result{};
  as_eigen(result) = v;
  return result;
}

}  // namespace nlo::inline NLO_ISA
