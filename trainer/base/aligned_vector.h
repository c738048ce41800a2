// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

namespace nlo::trainer {

/// A vector whose rows are read by whole SIMD registers. Its memory is aligned to a cache line; otherwise every 64-byte
/// load would touch two cache lines, and products, which are limited by loads, would wait.
template <class Scalar>
using AlignedVector = std::vector<Scalar, Eigen::aligned_allocator<Scalar>>;

}  // namespace nlo::trainer
