// SPDX-License-Identifier: MIT
// One step and estimate of an observer. count.cpp counts its instructions; with idle.cpp its size is measured. Macros
// choose the observer and its network, see CMakeLists.txt.
#include "bench/embedded/fly.h"

#include "bench/embedded/flown_model.h"

namespace {

constinit Observer observer{kModel};
volatile float measured = 0.5F;

}  // namespace

float x_hat[2];
extern const unsigned observer_bytes = sizeof(Observer);

void step_and_estimate() {
  {
    Observer::Output y;
    Observer::Input u;
    for (float& entry : y.values) entry = measured;
    for (float& entry : u.values) entry = measured;
    static_cast<void>(step(observer, y, u));
  }
#if NLO_EIGEN
  nlo::bench::eigen_estimate<kActivation>(kLayers, observer.latent().data(), x_hat);
#elif NLO_NAIVE
  nlo::bench::naive_estimate<kActivation>(kLayers, observer.latent().data(), x_hat);
#else
  const auto estimate = observer.estimate();
  x_hat[0] = estimate[0];
  x_hat[1] = estimate[1];
#endif
}
