// SPDX-License-Identifier: MIT
#include "trainer/judge/compare/table_filter.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "codegen/base/error.h"
#include "trainer/base/coordinate_search.h"
#include "trainer/judge/evaluation/text.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/plant_registry.h"

namespace nlo::trainer {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Makes filters of one name. Each thread needs a copy, because each copy has its own plant.
class Maker {
 public:
  Maker(std::string_view name, const Experiment& nominal, const NoiseConfig& noise, FilterTuning tuning = {})
      : row_(find_filter(name)),
        tuning_(std::move(tuning)),
        context_(filter_context(nominal, noise, {})),
        channels_(*nominal.plant, *make_plant(*nominal.plant)) {
    if (row_ == nullptr)
      throw codegen::Error(fmt::format("no filter \"{}\"; there are {}", name, fmt::join(filter_names(), ", ")));
    const std::string unfit = row_->unfit(context_);
    if (!unfit.empty()) throw codegen::Error(fmt::format("{} cannot be used for this plant: {}", name, unfit));
  }
  Maker(const Maker& other)
      : row_(other.row_), tuning_(other.tuning_), context_(other.context_), channels_(other.channels_) {
    context_.plant = lane_plant(make_plant(context_.config));
  }

  std::unique_ptr<LaneFilter> make() const { return row_->make(context_, {tuning_}, 1); }
  const FilterContext& context() const { return context_; }
  const PlantChannels& channels() const { return channels_; }

 private:
  const FilterRow* row_;
  FilterTuning tuning_;
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
                              bool held_inputs, bool with_intervals, const FilterTuning& tuning) {
  return [maker = Maker(name, nominal, noise, tuning), held_inputs, with_intervals]() -> Estimator {
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

namespace {

using Eigen::Index;

constexpr double kNoGate = 1e2;  // [standard deviations]; so large that it rejects no sample
constexpr double kUsualGate = 3.5;
constexpr double kWidest = 12.0;  // largest change of a factor in the search [decades]

using Factors = std::vector<TunedFactor>;

bool has_gate(const Factors& factors, const VectorXd& x) {
  const auto count = static_cast<Index>(factors.size());
  return x.size() > count && std::pow(10.0, x[count]) < kNoGate;
}

double factor_at(const VectorXd& x, std::size_t i) {
  return std::pow(10.0, std::clamp(x[static_cast<Index>(i)], -kWidest, kWidest));
}

FilterTuning tuning_of(const Factors& factors, const VectorXd& x) {
  FilterTuning tuning;
  for (std::size_t i = 0; i < factors.size(); ++i)
    if (x[static_cast<Index>(i)] != 0.0) factors[i].set(tuning, factor_at(x, i));
  if (has_gate(factors, x)) tuning.gate = std::pow(10.0, std::max(x[static_cast<Index>(factors.size())], -1.0));
  return tuning;
}

/// Returns the starts of a search: all combinations of the factors' decades, with and without a gate.
std::vector<VectorXd> grid(const Factors& factors, bool gated) {
  const auto count = static_cast<Index>(factors.size());
  std::vector<VectorXd> points{VectorXd::Zero(count + (gated ? 1 : 0))};
  const auto spread = [&](Index coordinate, const std::vector<double>& values) {
    std::vector<VectorXd> all;
    for (const VectorXd& point : points)
      for (const double value : values) {
        all.push_back(point);
        all.back()[coordinate] = value;
      }
    points = std::move(all);
  };
  for (Index i = 0; i < count; ++i) spread(i, factors[static_cast<std::size_t>(i)].decades);
  if (gated) spread(count, {std::log10(kNoGate), std::log10(kUsualGate)});
  return points;
}

std::string in_words(const Factors& factors, const VectorXd& x, const FilterTuning& tuning) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  for (std::size_t i = 0; i < factors.size(); ++i)
    if (x[static_cast<Index>(i)] != 0.0) add(fmt::format("{} x {}", factors[i].name, significant(factor_at(x, i), 2)));
  if (std::isfinite(tuning.gate)) add("gate " + significant(tuning.gate, 2));
  return text.empty() ? "as shipped" : text;
}

}  // namespace

TunedFilter tune_filter(const FilterRow& row, const FilterContext& context, const ComparedRuns& runs,
                        const std::atomic<bool>* stop) {
  TunedFilter result;
  const Factors factors = row.factors(context);
  const CostsOf costs = [&](const std::vector<VectorXd>& points) {
    std::vector<FilterTuning> tunings;
    for (const VectorXd& point : points) tunings.push_back(tuning_of(factors, point));
    const auto count = static_cast<Index>(points.size());
    const LaneRuns lanes = repeated(runs.measured, count);
    const auto filter = row.make(context, tunings, lanes.lanes());
    const Eigen::ArrayXd squares = squared_errors(*filter, lanes, runs);
    std::vector<double> norms;
    const Index each = squares.size() / count;
    for (Index t = 0; t < count; ++t) norms.push_back(std::sqrt(squares.segment(t * each, each).mean()));
    result.evaluations += static_cast<int>(count);
    return norms;
  };
  const std::vector<VectorXd> points = grid(factors, row.has_gate);
  const std::vector<double> found = costs(points);
  std::size_t best = 0;
  for (std::size_t i = 1; i < found.size(); ++i)
    if (found[i] < found[best]) best = i;
  const Tuned tuned = coordinate_search(points[best], costs, true, stop, row.most_sweeps);
  result.tuning = tuning_of(factors, tuned.x);
  result.text = in_words(factors, tuned.x, result.tuning);
  result.norm = tuned.cost;
  return result;
}

}  // namespace nlo::trainer
