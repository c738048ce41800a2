// SPDX-License-Identifier: MIT
// NLO_REFERENCES is the name of the function that this file defines.
#include "bench/references.h"

#include "bench/reference_networks.h"

namespace nlo::bench {
namespace {

template <Activation kKind, int kWidth, int kDepth>
References references() {
  return {[](const float* in, float* out) {
            static const auto network = naive_network<kKind>(random_layers<3, kWidth, kDepth, 2>());
            network.evaluate(in, out);
          },
          [](const float* in, float* out) {
            static const auto network = eigen_network<kKind, Eigen::RowMajor>(random_layers<3, kWidth, kDepth, 2>());
            network.evaluate(in, out);
          },
          [](const float* in, float* out) {
            static const auto network = eigen_network<kKind, Eigen::ColMajor>(random_layers<3, kWidth, kDepth, 2>());
            network.evaluate(in, out);
          }};
}

template <Activation kKind>
References of_size(int width, int depth) {
  if (width == 50 && depth == 4) return references<kKind, 50, 4>();
  if (width == 32 && depth == 2) return references<kKind, 32, 2>();
  if (width == 16 && depth == 2) return references<kKind, 16, 2>();
  return {};
}

}  // namespace

References NLO_REFERENCES(Activation kind, int width, int depth) {
  if (kind == Activation::kTanh) return of_size<Activation::kTanh>(width, depth);
  if (kind == Activation::kRelu) return of_size<Activation::kRelu>(width, depth);
  return {};
}

}  // namespace nlo::bench
