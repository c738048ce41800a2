// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

namespace nlo::trainer {

/// For rows that are read by whole SIMD registers: it starts where a register may. From elsewhere every 64-byte load
/// would touch two cache lines, and a product that takes two loads per multiply-add unit and cycle would wait for them.
template <class Scalar>
using AlignedVector = std::vector<Scalar, Eigen::aligned_allocator<Scalar>>;

}  // namespace nlo::trainer
