// SPDX-License-Identifier: MIT
// Straightforward code as functions: plain loops and products of fixed-size Eigen matrices, on the weights of
// random_mlp(). It is compiled with the flags of the benchmark, and again with -ffast-math. Each version is a shared
// library, because a program must not have two versions of Eigen's templates.
#pragma once

#include <nlo/kernels/activation.h>

namespace nlo::bench {

/// The network 3-WxD-2 by each reference: out (2) = net(in), in (3).
struct References {
  using Evaluate = void (*)(const float* in, float* out);
  Evaluate naive, eigen_rows, eigen_columns;
};

/// Available networks: tanh and relu, 50x4, 32x2 and 16x2. For others, the pointers are null.
__attribute__((visibility("default"))) References plain_references(Activation kind, int width, int depth);
__attribute__((visibility("default"))) References fast_math_references(Activation kind, int width, int depth);

}  // namespace nlo::bench
