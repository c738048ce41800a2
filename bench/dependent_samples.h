// SPDX-License-Identifier: MIT
// Computes one sample of an observer with each call. Each estimate feeds the next measurement, so that no part of a
// sample can start before the previous sample is complete.
#pragma once

#include <benchmark/benchmark.h>
#include <nlo/kkl_batch.h>
#include <nlo/kkl_observer.h>

#include <functional>
#include <memory>

#include "bench/references.h"

namespace nlo::bench {

inline constexpr int kFleet = 32;

/// Computes one sample, which depends on the one before.
using Sample = std::function<void()>;

/// Returns a measurement that depends on the last estimate.
inline float next_measurement(float x_hat) {
  return 0.5F * x_hat + 0.1F;
}

template <class Observer>
Sample sample_of(const typename Observer::Model& model) {
  return [observer = Observer{model}, y = 1.0F]() mutable {
    if constexpr (Observer::kDriven) {
      benchmark::DoNotOptimize(observer.step(y, 0.1F));
    } else {
      benchmark::DoNotOptimize(observer.step(y));
    }
    if constexpr (nlo::KnowsError<typename Observer::Model>) {
      auto estimated = observer.estimate_with_error();
      benchmark::DoNotOptimize(estimated);
      y = next_measurement(estimated.x_hat[0]);
    } else {
      y = next_measurement(observer.estimate()[0]);
    }
  };
}

/// Runs step() of the runtime, then another network on its latent state.
template <class Model>
Sample sample_with(const Model& model, References::Evaluate evaluate) {
  return [observer = nlo::KklObserver{model}, evaluate, y = 1.0F]() mutable {
    benchmark::DoNotOptimize(observer.step(y));
    float x_hat[2];
    evaluate(observer.latent().data(), x_hat);
    y = next_measurement(x_hat[0]);
  };
}

/// Computes a sample of every plant of a batch.
template <class Model>
Sample sample_of_fleet(const Model& model) {
  struct Fleet {
    nlo::KklBatch<Model, kFleet> batch;
    float y[1][kFleet], x_hat[2][kFleet];
  };
  const auto fleet = std::make_shared<Fleet>(Fleet{nlo::KklBatch<Model, kFleet>{model}, {}, {}});
  return [fleet] {
    benchmark::DoNotOptimize(fleet->batch.step(fleet->y));
    fleet->batch.estimate(fleet->x_hat);
    for (int n = 0; n < kFleet; ++n) fleet->y[0][n] = next_measurement(fleet->x_hat[0][n]);
    benchmark::ClobberMemory();
  };
}

}  // namespace nlo::bench
