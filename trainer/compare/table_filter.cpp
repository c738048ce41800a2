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
                              bool held_inputs, bool with_intervals) {
  return [maker = Maker(name, nominal, noise), held_inputs, with_intervals]() -> Estimator {
    return [own = maker, held_inputs, with_intervals](const MatrixXd& outputs, const MatrixXd& inputs,
                                                      const VectorXd& time_s) -> Estimates {
      const PlantChannels& channels = own.channels();
      FilteredRun run = filtered(*own.make(), one_run(channels.plant_outputs(outputs), inputs, time_s, held_inputs));
      if (with_intervals && channels.plain() && run.deviations.size() > 0)
        return normal_intervals(std::move(run.x_hat), run.deviations);
      return channels.states(run.x_hat);
    };
  };
}

LoopEstimators filter_in_loop(std::string_view name, const Experiment& nominal, const NoiseConfig& noise) {
  return [maker = Maker(name, nominal, noise), held = nominal.observer.input_hold == Hold::kZeroOrder](std::uint64_t) {
    return std::make_unique<InLoop>(maker, held);
  };
}

}  // namespace nlo::trainer
