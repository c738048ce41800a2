// SPDX-License-Identifier: MIT
#include "trainer/plants/loop_estimator.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <utility>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/replay/reference_observer.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/plants/plant_channels.h"

namespace nlo::trainer {
namespace {

std::vector<std::string> names(const std::vector<codegen::Channel>& channels) {
  std::vector<std::string> result;
  for (const codegen::Channel& channel : channels) result.push_back(channel.name);
  return result;
}

class Observer final : public LoopEstimator {
 public:
  Observer(const codegen::Model& model, double sample_period_s) : observer_(model), sample_period_s_(sample_period_s) {}

  Eigen::VectorXd step(const Eigen::VectorXd& y, const Eigen::VectorXd& u) override {
    observer_.step(y, u, sample_period_s_);
    return observer_.estimate().cast<double>();
  }

 private:
  codegen::ReferenceObserver<float> observer_;
  double sample_period_s_;
};

class NoisyEstimator final : public LoopEstimator {
 public:
  NoisyEstimator(std::unique_ptr<LoopEstimator> estimator, const NoiseConfig& noise, std::uint64_t seed,
                 std::uint64_t run)
      : estimator_(std::move(estimator)), noise_(noise, seed, run) {}

  Eigen::VectorXd step(const Eigen::VectorXd& y, const Eigen::VectorXd& u) override {
    return estimator_->step(noise_.on(y), u);
  }

 private:
  std::unique_ptr<LoopEstimator> estimator_;
  MeasurementNoise noise_;
};

}  // namespace

LoopEstimators observer_in_loop(const codegen::Model& model, const Experiment& experiment, const Plant& plant) {
  const PlantChannels channels(*experiment.plant, plant);
  if (names(model.states) != names(channels.states()) || names(model.outputs) != names(plant.outputs()) ||
      names(codegen::inputs(model)) != names(plant.inputs()))
    throw codegen::Error(fmt::format(
        "\"{}\" cannot close the loop: it must read the outputs and inputs of the plant {} and estimate {}; train it "
        "with [feedback], or with [excitation] and these states",
        model.name, plant.name(), fmt::join(names(channels.states()), ", ")));
  return [&model, sample_period_s = experiment.simulation.sample_period_s](std::uint64_t) {
    return std::make_unique<Observer>(model, sample_period_s);
  };
}

LoopEstimators with_noise(LoopEstimators estimators, const NoiseConfig& noise, std::uint64_t seed) {
  return [estimators = std::move(estimators), noise, seed](std::uint64_t run) {
    return std::make_unique<NoisyEstimator>(estimators(run), noise, seed, run);
  };
}

}  // namespace nlo::trainer
