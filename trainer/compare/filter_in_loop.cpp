// SPDX-License-Identifier: MIT
#include "trainer/compare/filter_in_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "codegen/base/error.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/registry.h"

namespace nlo::trainer {
namespace {

class Filter final : public LoopEstimator {
 public:
  Filter(const FilterRow& row, const Experiment& nominal, const NoiseConfig& noise)
      : context_(filter_context(nominal, noise, {})),
        channels_(*nominal.plant, *make_plant(*nominal.plant)),
        filter_(row.make(context_, {FilterTuning{}}, 1)) {
    samples_.sample_period_s = nominal.simulation.sample_period_s;
    samples_.held_inputs = nominal.observer.input_hold == Hold::kZeroOrder;
  }

  Eigen::VectorXd step(const Eigen::VectorXd& y, const Eigen::VectorXd& u) override {
    samples_.outputs.emplace_back(y);
    samples_.inputs.emplace_back(u);
    return channels_.states(filter_->step(samples_, samples_.samples() - 1));
  }

 private:
  FilterContext context_;
  PlantChannels channels_;
  std::unique_ptr<LaneFilter> filter_;
  LaneRuns samples_;
};

}  // namespace

LoopEstimators filter_in_loop(std::string_view name, const Experiment& nominal, const NoiseConfig& noise) {
  const auto rows = filter_table();
  const auto row = std::find_if(rows.begin(), rows.end(), [&](const FilterRow& r) { return r.name == name; });
  if (row == rows.end()) throw codegen::Error(fmt::format("no filter \"{}\" for the loop", name));
  const std::string unfit = row->unfit(filter_context(nominal, noise, {}));
  if (!unfit.empty()) throw codegen::Error(fmt::format("{} cannot close the loop: {}", name, unfit));
  return [row = &*row, &nominal, noise](std::uint64_t) { return std::make_unique<Filter>(*row, nominal, noise); };
}

}  // namespace nlo::trainer
