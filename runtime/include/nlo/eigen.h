// SPDX-License-Identifier: MIT
// Eigen views of the runtime's vectors, without a copy. Optional: only those who compute with Eigen include it.
#pragma once

#include <Eigen/Core>

#include "nlo/vector.h"

namespace nlo {

/// The vector as an Eigen column vector, in place.
template <class Scalar, int kN>
auto as_eigen(Vector<Scalar, kN>& v) {
  return Eigen::Map<Eigen::Matrix<Scalar, kN, 1>>(v.data());
}
template <class Scalar, int kN>
auto as_eigen(const Vector<Scalar, kN>& v) {
  return Eigen::Map<const Eigen::Matrix<Scalar, kN, 1>>(v.data());
}

/// A fixed-size Eigen column vector as the runtime takes it.
template <class Derived>
auto from_eigen(const Eigen::MatrixBase<Derived>& v) {
  static_assert(Derived::ColsAtCompileTime == 1 && Derived::RowsAtCompileTime > 0, "a fixed-size column vector");
  Vector<typename Derived::Scalar, Derived::RowsAtCompileTime> result{};
  as_eigen(result) = v;
  return result;
}

}  // namespace nlo
