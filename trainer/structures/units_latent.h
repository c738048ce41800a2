// SPDX-License-Identifier: MIT
// Latent systems of gated units over the segments of a group, by forward() and backward() of GatedUnits.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "trainer/gradients/sensitivity/latent_dynamics.h"
#include "trainer/structures/gated_units.h"

namespace nlo::trainer {

template <class Units>
class UnitsLatent final : public LatentDynamics {
 public:
  /// make() returns the units for one thread. period_s: sample period, the unit of the rates.
  template <class Make>
  UnitsLatent(int rows, int parameters, double period_s, const std::vector<double>& steps_s, int threads,
              const Make& make)
      : LatentDynamics(rows),
        period_s_(period_s),
        steps_s_(steps_s),
        parameters_(static_cast<std::size_t>(parameters)) {
    for (int t = 0; t < threads; ++t) workers_.push_back({make(), {}});
  }

  void prepare(const float* parameters) override {
    std::copy_n(parameters, parameters_.size(), parameters_.begin());
    for (Worker& worker : workers_) worker.units->prepare(parameters_.data());
  }

  void forward(SegmentGroup& group, int thread) override {
    Worker& worker = workers_[static_cast<std::size_t>(thread)];
    worker.units->forward(run_of(group, worker));
  }

  void backward(SegmentGroup& group, int thread) override {
    Worker& worker = workers_[static_cast<std::size_t>(thread)];
    GatedRun<float> run = run_of(group, worker);
    run.cotangent = group.cotangent.data();
    worker.units->backward(run, group.gradient);
  }

 private:
  struct Worker {
    std::unique_ptr<Units> units;
    std::vector<float> periods;
  };

  GatedRun<float> run_of(SegmentGroup& group, Worker& worker) const {
    GatedRun<float> run{.length = group.length, .readings = group.readings.data(), .latent = group.latent.data()};
    if (!group.held.empty()) run.held = group.held.data();
    if (group.step_of.empty()) return run;
    worker.periods.assign(group.step_of.size(), 1.0F);
    for (std::size_t i = kGroup; i < group.step_of.size(); ++i) {
      const double step_s = steps_s_[static_cast<std::size_t>(group.step_of[i - kGroup])];
      worker.periods[i] = static_cast<float>(step_s / period_s_);
    }
    run.periods = worker.periods.data();
    return run;
  }

  double period_s_;
  const std::vector<double>& steps_s_;
  std::vector<float> parameters_;
  std::vector<Worker> workers_;
};

}  // namespace nlo::trainer
