// SPDX-License-Identifier: MIT
// The observer that a program of this folder runs. Macros choose it, see CMakeLists.txt. NLO_HEADER and NLO_MODEL are
// the header and the namespace of an exported observer.
#pragma once

#include <type_traits>

#if defined(NLO_HEADER)
#include NLO_HEADER
#else
#include "bench/random_model.h"
#if NLO_INT16
#include "bench/random_quantised_model.h"
#elif !NLO_EIGEN && !NLO_NAIVE
#include "bench/random_structures.h"
#endif
#if NLO_EIGEN || NLO_NAIVE
#include "bench/embedded/plain_networks.h"
#endif
#endif

namespace {

using nlo::Activation;
using nlo::Arithmetic;

#if defined(NLO_HEADER)
constexpr const auto& kModel = nlo::NLO_MODEL::kModel;
#else
constexpr Activation kActivation = Activation::NLO_ACTIVATION;
constexpr int kWidth = 50, kDepth = 4;  // the paper's network, 3-50x4-2

#if NLO_GRU && NLO_INT16
constexpr auto kModel = nlo::bench::random_quantised_gated_model<64, 0, 32, 32>();
#elif NLO_GATED && NLO_INT16
constexpr auto kModel = nlo::bench::random_quantised_gated_model<32>();
#elif NLO_GENERAL && NLO_INT16  // only T* is in integers
constexpr auto kModel = nlo::bench::random_general_model<kActivation, kWidth, 1>(
    nlo::bench::random_quantised_map<kActivation, kWidth, 1>());
#elif NLO_GRU
constexpr auto kModel = nlo::bench::random_gated_model<64, 0, 32, 32>();
#elif NLO_GATED
constexpr auto kModel = nlo::bench::random_gated_model<32>();  // with T* 32-32-2 tanh
#elif NLO_PRIOR
constexpr auto kModel = nlo::bench::random_prior_model<24>();  // with T* 26-16-2 tanh
#elif NLO_CARRIED
constexpr auto kModel = nlo::bench::random_carried_model();
#elif NLO_LUENBERGER
constexpr auto kModel = nlo::bench::random_luenberger_model<kActivation, kWidth, 1>();
#elif NLO_GENERAL
constexpr auto kModel = nlo::bench::random_general_model<kActivation, kWidth, 1>();
#elif NLO_DRIVEN
constexpr auto kModel = nlo::bench::random_driven_model<kActivation, 32, 2>();
#elif NLO_INT16
constexpr auto kModel = nlo::bench::random_quantised_model<kActivation, kWidth, kDepth>();
#elif NLO_EIGEN || NLO_NAIVE
constexpr auto kLayers = nlo::bench::random_layers<3, kWidth, kDepth, 2>();
constexpr auto kModel = nlo::bench::random_kkl_model<kActivation, 1, 1>();  // only its latent system is used
#else
constexpr auto kModel = nlo::bench::random_kkl_model<kActivation, kWidth, kDepth>();
#endif
#endif
using Observer = nlo::SampledObserver<std::remove_cvref_t<decltype(kModel)>, Arithmetic::NLO_ARITHMETIC>;

/// A template, so that the branch for other observers is not compiled.
template <class Called, class... Dt>
nlo::StepStatus step(Called& one, const typename Called::Output& y, const typename Called::Input& u, Dt... dt_s) {
  if constexpr (Called::kDriven) {
    return one.step(y, u, dt_s...);
  } else {
    return one.step(y, dt_s...);
  }
}

}  // namespace
