// SPDX-License-Identifier: MIT
#include "trainer/compare/table_filter.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <string>

#include "codegen/base/error.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/registry.h"

namespace nlo::trainer {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// What makes filters of one name. Copies are for other threads: each has a plant of its own.
class Maker {
 public:
  Maker(std::string_view name, const Experiment& nominal, const NoiseConfig& noise)
      : row_(find_filter(name)),
        context_(filter_context(nominal, noise, {})),
        channels_(*nominal.plant, *make_plant(*nominal.plant)) {
    if (row_ == nullptr)
      throw codegen::Error(fmt::format("no filter \"{}\"; there are {}", name, fmt::join(filter_names(), ", ")));
    const std::string unfit = row_->unfit(context_);
    if (!unfit.empty()) throw codegen::Error(fmt::format("{} does not fit this plant: {}", name, unfit));
  }
  Maker(const Maker& other) : row_(other.row_), context_(other.context_), channels_(other.channels_) {
    context_.plant = lane_plant(make_plant(context_.config));
  }

  std::unique_ptr<LaneFilter> make() const { return row_->make(context_, {FilterTuning{}}, 1); }
  const FilterContext& context() const { return context_; }
  const PlantChannels& channels() const { return channels_; }

  FilteredRun over(const MatrixXd& outputs, const MatrixXd& inputs, const VectorXd& time_s, bool held_inputs) const {
    return filtered(*make(), one_run(channels_.plant_outputs(outputs), inputs, time_s, held_inputs));
  }

 private:
  const FilterRow* row_;
  FilterContext context_;
  PlantChannels channels_;
};

class InLoop final : public LoopEstimator {
 public:
  InLoop(const Maker& maker, bool held_inputs) : maker_(maker), filter_(maker_.make()) {
    samples_.sample_period_s = maker_.context().sample_period_s;
    samples_.held_inputs = held_inputs;
  }

  VectorXd step(const VectorXd& y, const VectorXd& u) override {
    samples_.outputs.emplace_back(y);
    samples_.inputs.emplace_back(u);
    return maker_.channels().states(filter_->step(samples_, samples_.samples() - 1));
  }

 private:
  Maker maker_;
  std::unique_ptr<LaneFilter> filter_;
  LaneRuns samples_;
};

}  // namespace

EstimatorFactory table_filter(std::string_view name, const Experiment& nominal, const NoiseConfig& noise,
                              bool held_inputs) {
  return [maker = Maker(name, nominal, noise), held_inputs]() -> Estimator {
    return [own = maker, held_inputs](const MatrixXd& outputs, const MatrixXd& inputs, const VectorXd& time_s) {
      return own.channels().states(own.over(outputs, inputs, time_s, held_inputs).x_hat);
    };
  };
}

IntervalEstimatorFactory table_filter_intervals(std::string_view name, const Experiment& nominal,
                                                const NoiseConfig& noise, bool held_inputs) {
  const Maker maker(name, nominal, noise);
  if (!maker.channels().plain() || maker.make()->deviations().size() == 0) return nullptr;
  return [maker, held_inputs]() -> IntervalEstimator {
    return [own = maker, held_inputs](const MatrixXd& outputs, const MatrixXd& inputs, const VectorXd& time_s) {
      FilteredRun run = own.over(outputs, inputs, time_s, held_inputs);
      return normal_intervals(std::move(run.x_hat), run.deviations);
    };
  };
}

LoopEstimators filter_in_loop(std::string_view name, const Experiment& nominal, const NoiseConfig& noise) {
  return [maker = Maker(name, nominal, noise), held = nominal.observer.input_hold == Hold::kZeroOrder](std::uint64_t) {
    return std::make_unique<InLoop>(maker, held);
  };
}

}  // namespace nlo::trainer
