// SPDX-License-Identifier: MIT
// The networks whose results instruction_set_bits.h holds: estimates, products, batches and their z, deviations of
// errors, and gated units of the fast policy, whose bits depend on the vector length and on fused multiply-adds.
#pragma once

#include <nlo/jvp.h>
#include <nlo/kkl_batch.h>
#include <nlo/kkl_observer.h>

#include "bench/random_error_head.h"
#include "bench/random_model.h"
#include "bench/random_structures.h"
#include "tests/runtime/instruction_set_bits.h"

namespace nlo::testing {

template <Activation kKind>
struct InstructionSetModel {
  static constexpr auto kModel = bench::random_kkl_model<kKind, 50, 2>();
};

/// Calls work(in, direction) with inputs of size one.
template <class Work>
void for_each_round(const Work& work) {
  bench::RandomUniform random{7};
  for (int round = 0; round < instruction_set::kRounds; ++round) {
    float in[3], direction[3];
    for (float& value : in) value = random();
    for (float& value : direction) value = random();
    work(round, in, direction);
  }
}

/// Initial state and measurements of a plant, exact without rounding, because each build computes them.
template <class State>
State begun(State state, int plant) {
  for (int r = 0; r < 3; ++r) state.z[r] = 0.0625F * static_cast<float>(plant + 1) - static_cast<float>(r);
  state.started = 1;
  return state;
}
inline float measured(int round, int plant) {
  return 0.25F * static_cast<float>((round + plant) % 7) - 0.75F;
}

template <class Model>
void run_recurrence(const Model& model, float (&latent)[3][instruction_set::kWholeBlocks]) {
  KklBatch<Model, instruction_set::kWholeBlocks> batch{model};
  for (int n = 0; n < instruction_set::kWholeBlocks; ++n) (void)batch.restore(n, begun(batch.save(n), n));
  for (int round = 0; round < instruction_set::kRounds; ++round) {
    float y[1][instruction_set::kWholeBlocks];
    for (int n = 0; n < instruction_set::kWholeBlocks; ++n) y[0][n] = measured(round, n);
    (void)batch.step(y);
  }
  for (int n = 0; n < instruction_set::kWholeBlocks; ++n)
    for (int r = 0; r < 3; ++r) latent[r][n] = batch.latent(n)[r];
}

inline instruction_set::Bits run_networks() {
  static constexpr auto& kTanh = InstructionSetModel<Activation::kTanh>::kModel;
  static constexpr auto& kSilu = InstructionSetModel<Activation::kSilu>::kModel;
  static constexpr auto kSure = bench::with_error_head(kTanh.inverse_map);
  instruction_set::Bits bits{};
  for_each_round([&](int round, const float(&in)[3], const float(&direction)[3]) {
    kTanh.inverse_map.evaluate(in, bits.estimate[round]);
    jvp(kTanh.inverse_map, in, direction, bits.jvp[round]);
    jvp(kSilu.inverse_map, in, direction, bits.silu_jvp[round]);
    float x_hat[2];
    kSure.evaluate(in, x_hat, bits.log2_sigma[round]);
  });
  static constexpr auto kGated = bench::random_gated_model<instruction_set::kUnits>();
  GatedObserver gated{kGated};
  for (int round = 0; round < instruction_set::kRounds; ++round) {
    (void)gated.step(0.1F * static_cast<float>(round % 7));
    for (int i = 0; i < instruction_set::kUnits; ++i) bits.gated[round][i] = gated.latent()[i];
  }
  KklBatch<std::remove_cvref_t<decltype(kTanh)>, instruction_set::kPlants> batch{kTanh};
  for (int n = 0; n < instruction_set::kPlants; ++n) {
    auto state = batch.save(n);
    for (int r = 0; r < 3; ++r) state.z[r] = 0.05F * static_cast<float>(n + 1) - static_cast<float>(r);
    (void)batch.restore(n, state);
  }
  batch.estimate(bits.batch);
  run_recurrence(kTanh, bits.latent);
  return bits;
}

}  // namespace nlo::testing
