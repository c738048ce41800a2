// SPDX-License-Identifier: MIT
// The code that flies on a microcontroller, in one object file for symbol_audit_core.sh: both policies, both formats.
#include "bench/random_quantised_model.h"

namespace {

using nlo::Activation;
using nlo::Arithmetic;

constexpr auto kTanh = nlo::bench::random_kkl_model<Activation::kTanh, 9, 1>();
constexpr auto kInt16 = nlo::bench::random_quantised_model<Activation::kTanh, 9, 1>();

constinit nlo::KklObserver<std::remove_const_t<decltype(kTanh)>> fast{kTanh};
constinit nlo::KklObserver<std::remove_const_t<decltype(kTanh)>, Arithmetic::kDeterministic> exact{kTanh};
constinit nlo::KklObserver<std::remove_const_t<decltype(kInt16)>> quantised{kInt16};

template <class Observer>
int fly(Observer& observer, float y, float dt_s, float* x_hat) {
  int status = static_cast<int>(observer.step(y)) + static_cast<int>(observer.step(y, dt_s));
  status += static_cast<int>(observer.step_missed()) + static_cast<int>(observer.warm_start(y));
  const auto estimate = observer.estimate();
  x_hat[0] = estimate[0];
  x_hat[1] = estimate[1];
  const auto saved = observer.save();
  observer.reset();
  return status + (observer.restore(saved) ? 1 : 0) + (observer.in_domain() ? 2 : 0);
}

}  // namespace

extern "C" int audited_loop(float y, float dt_s, float* x_hat) {
#if defined(NLO_CONTROL)
  x_hat[0] = static_cast<float>(static_cast<double>(y) * 0.1);
#endif
  return fly(fast, y, dt_s, x_hat) + fly(exact, y, dt_s, x_hat + 2) + fly(quantised, y, dt_s, x_hat + 4);
}
