// SPDX-License-Identifier: MIT
// The kernels whose cycles port_models.py counts, one function each: networks of the paper's size and small ones, a
// step of gated units, one block of a batch. They are compiled like in a user's program and never run.
#include <nlo/gate.h>
#include <nlo/mlp_batch.h>

#include "bench/random_model.h"
#include "bench/random_structures.h"

namespace {

using nlo::Activation;
using nlo::Arithmetic;

template <Activation kKind, int kWidth, int kDepth>
constexpr auto kNetwork = nlo::bench::random_kkl_model<kKind, kWidth, kDepth>().inverse_map.mlp;
constexpr auto kGated = nlo::bench::random_gated_model<32>();
constexpr int kBlock = nlo::kernels::kBatchBlock<float, NLO_NATIVE_BYTES>;

}  // namespace

// in: z; out: x_hat. For a batch they are [value][plant].
#define NLO_PORT_MODEL(NAME, KIND, WIDTH, DEPTH)                                   \
  extern "C" void NAME(const float* in, float* out);                               \
  extern "C" void NAME(const float* in, float* out) {                              \
    kNetwork<Activation::KIND, WIDTH, DEPTH>.evaluate<Arithmetic::kFast>(in, out); \
  }
#define NLO_PORT_MODEL_BATCH(NAME, KIND)                                                        \
  extern "C" void NAME(const float* in, float* out);                                            \
  extern "C" void NAME(const float* in, float* out) {                                           \
    nlo::evaluate_batch<Arithmetic::kFast, kBlock>(kNetwork<Activation::KIND, 50, 4>, in, out); \
  }
NLO_PORT_MODEL(relu_50x4, kRelu, 50, 4)
NLO_PORT_MODEL(tanh_50x4, kTanh, 50, 4)
NLO_PORT_MODEL(relu_16x2, kRelu, 16, 2)
NLO_PORT_MODEL(tanh_16x2, kTanh, 16, 2)
NLO_PORT_MODEL(relu_32x2, kRelu, 32, 2)
NLO_PORT_MODEL(tanh_32x2, kTanh, 32, 2)
NLO_PORT_MODEL_BATCH(relu_batch, kRelu)
NLO_PORT_MODEL_BATCH(tanh_batch, kTanh)

// One sample period: in = [z; y] with padding; the step changes z.
extern "C" void gated_32(float* in, float* gate, float* target, float (&z)[32]);
extern "C" void gated_32(float* in, float* gate, float* target, float (&z)[32]) {
  nlo::kernels::gated_step<Arithmetic::kFast, true>(kGated.gates.mlp.layer, kGated.candidate.mlp.layer, in, gate,
                                                    target, z, 1.0F);
}
