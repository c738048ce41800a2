// SPDX-License-Identifier: MIT
// Everything that an observer does in flight, as one object file for symbol_audit.sh to look into.
#include "bench/random_model.h"

namespace {

constexpr auto kModel = nlo::bench::random_kkl_model<nlo::Activation::kTanh, 16, 2>();
constexpr auto kSiluModel = nlo::bench::random_kkl_model<nlo::Activation::kSilu, 12, 1>();
using Observer = nlo::KklObserver<decltype(kModel)>;
using SiluObserver = nlo::KklObserver<decltype(kSiluModel)>;

constinit Observer observer{kModel};
constinit SiluObserver silu_observer{kSiluModel};

}  // namespace

extern "C" int audited_loop(float y, float dt_s, float* x_hat) {
  int status = static_cast<int>(observer.step(y));
  status += static_cast<int>(observer.step(y, dt_s));
  status += static_cast<int>(observer.step_missed());
  const auto estimate = observer.estimate();
  x_hat[0] = estimate[0];
  x_hat[1] = estimate[1];
  status += static_cast<int>(silu_observer.step(y));
  x_hat[2] = silu_observer.estimate()[0];
  return status + (observer.in_domain() ? 0 : 100) + static_cast<int>(observer.status());
}

extern "C" int audited_start(float y) {
  const auto saved = observer.save();
  observer.reset();
  int status = static_cast<int>(observer.warm_start(y));
  status += observer.reset(observer.latent(), {{y}}) ? 1 : 0;
  return status + (observer.restore(saved) ? 1 : 0);
}
