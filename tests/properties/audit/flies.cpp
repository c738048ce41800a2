// SPDX-License-Identifier: MIT
// All functions that an observer calls in flight, in one object file for symbol_audit.sh.
#include "bench/random_model.h"
#include "bench/random_structures.h"
#include "tests/runtime/structures.h"

namespace {

constexpr auto kModel = nlo::bench::random_kkl_model<nlo::Activation::kTanh, 16, 2>();
constexpr auto kSiluModel = nlo::bench::random_kkl_model<nlo::Activation::kSilu, 12, 1>();
constexpr auto kLuenbergerModel = nlo::bench::random_luenberger_model<nlo::Activation::kTanh, 16, 2>();
constexpr auto kGeneralModel = nlo::bench::random_general_model<nlo::Activation::kRelu, 12, 1>();
constexpr auto kDrivenModel = nlo::bench::random_driven_model<nlo::Activation::kTanh, 16, 2>();
constexpr auto kCarriedModel = nlo::testing::carried_model<float>();
constexpr auto kPriorModel = nlo::testing::prior_model<float>();
using Observer = nlo::KklObserver<decltype(kModel)>;
using SiluObserver = nlo::KklObserver<decltype(kSiluModel)>;

constinit Observer observer{kModel};
constinit SiluObserver silu_observer{kSiluModel};
constinit nlo::LuenbergerObserver luenberger_observer{kLuenbergerModel};
constinit nlo::GeneralObserver general_observer{kGeneralModel};
constinit nlo::DrivenKklObserver driven_observer{kDrivenModel};
constinit nlo::CarriedObserver carried_observer{kCarriedModel};
constinit nlo::PriorObserver prior_observer{kPriorModel};

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

extern "C" int audited_structures(float y, float u, float dt_s, float* x_hat) {
  int status = static_cast<int>(luenberger_observer.step(y));
  status += static_cast<int>(luenberger_observer.step(y, dt_s));
  status += static_cast<int>(general_observer.step(y));
  status += static_cast<int>(general_observer.step(y, dt_s));
  status += static_cast<int>(general_observer.step_missed());
  status += static_cast<int>(driven_observer.step(y, u));
  status += static_cast<int>(driven_observer.step(y, u, dt_s));
  status += static_cast<int>(driven_observer.step_missed({{u}}));
  status += static_cast<int>(carried_observer.step({{y, y, y}}, {{u, u, u}}));
  status += static_cast<int>(carried_observer.step({{y, y, y}}, {{u, u, u}}, dt_s));
  status += static_cast<int>(prior_observer.step(y));
  status += static_cast<int>(prior_observer.step(y, dt_s));
  x_hat[0] = luenberger_observer.estimate()[0] + prior_observer.estimate()[0];
  x_hat[1] = general_observer.estimate()[0];
  x_hat[2] = driven_observer.estimate()[0] + carried_observer.estimate()[0];
  return status + (driven_observer.in_domain() && general_observer.in_domain() ? 0 : 100);
}

extern "C" int audited_start(float y) {
  const auto saved = observer.save();
  observer.reset();
  int status = static_cast<int>(observer.warm_start(y));
  status += observer.reset(observer.latent(), {{y}}) ? 1 : 0;
  return status + (observer.restore(saved) ? 1 : 0);
}
