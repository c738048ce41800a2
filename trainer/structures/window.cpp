// SPDX-License-Identifier: MIT
// Window observer: z = the last n measurements of each output, newest first, x_hat = T*(z). Its latent system learns
// nothing; what it takes for the states is T*.
#include <fmt/format.h>
#include <nlo/explicit_rk.h>

#include <algorithm>
#include <cmath>

#include "trainer/base/draws.h"
#include "trainer/base/quantile.h"
#include "trainer/config/key_error.h"
#include "trainer/config/keys.h"
#include "trainer/structures/linear_latent_start.h"
#include "trainer/structures/model_networks.h"
#include "trainer/structures/module.h"

namespace nlo::trainer {
namespace {

/// Keys of [observer] that a window alone has.
struct WindowConfig {
  int samples = 16;
};

/// The rows of z are the outputs, each `samples` times, one sample older from row to row. What a gap has left out lies
/// on the hold, as in flight (nlo/window_observer.h).
class WindowLatent final : public LatentDynamics {
 public:
  WindowLatent(const ObserverStructure& structure, const std::vector<double>& steps_s)
      : LatentDynamics(structure.latent.rows),
        samples_(structure.latent.rows / structure.readings),
        hold_(structure.latent.hold),
        commands_from_(structure.latent.commands_from),
        steps_s_(steps_s),
        period_s_(value_at_rank(steps_s, 0.5)) {}  // most distinct steps are about one period, but for jitter and gaps

  void prepare(const float*) override {}

  void forward(SegmentGroup& group, int) override {
    for (int output = 0; output < rows() / samples_; ++output)
      for (int lane = 0; lane < kGroup; ++lane) run(group, output, static_cast<std::size_t>(lane));
  }

  void backward(SegmentGroup& group, int) override { group.gradient.clear(); }

 private:
  void run(SegmentGroup& group, int output, std::size_t lane) const {
    const auto y = [&](int time) { return group.readings[group.at(output, time) + lane]; };
    std::vector<float> window(static_cast<std::size_t>(samples_), y(0));
    for (int time = 0; time < group.length; ++time) {
      const int steps = time == 0 ? 0 : steps_between(group, time - 1, lane);
      for (int s = 1; s <= steps; ++s) {
        std::shift_right(window.begin(), window.end(), 1);
        const float part = output >= commands_from_    ? 1.0F
                           : hold_ == Hold::kZeroOrder ? 0.0F
                                                       : static_cast<float>(s) / static_cast<float>(steps);
        window.front() = s == steps ? y(time) : (1.0F - part) * y(time - 1) + part * y(time);
      }
      for (int i = 0; i < samples_; ++i)
        group.latent[group.at(output * samples_ + i, time) + lane] = window[static_cast<std::size_t>(i)];
    }
  }

  /// In sample periods, as flight counts them.
  int steps_between(const SegmentGroup& group, int time, std::size_t lane) const {
    if (group.step_of.empty()) return 1;
    const int step = group.step_of[static_cast<std::size_t>(time) * kGroup + lane];
    return pieces_of(steps_s_[static_cast<std::size_t>(step)], period_s_);
  }

  int samples_;
  Hold hold_;
  int commands_from_;
  const std::vector<double>& steps_s_;
  double period_s_;
};

class WindowStructure final : public TrainableStructure {
 public:
  std::string_view name() const override { return "window"; }

  std::vector<Key<ObserverConfig>> own_keys() const override {
    return {own_key<ObserverConfig>(key("samples", &WindowConfig::samples, between(1, 1024),
                                        "window: how many of the last measurements T* reads"))};
  }

  void check(const Experiment& experiment, const ChannelCounts&) const override {
    const ObserverConfig& o = experiment.observer;
    for (const auto& [key, given] : {std::pair{"eigenvalues", !o.eigenvalues.empty()},
                                     {"pairs", !o.pairs.empty()},
                                     {"clocks_s", !o.clocks_s.empty()},
                                     {"features", o.features != FeatureSet::kLatent}})
      if (given)
        throw KeyError(fmt::format("observer.{}", key),
                       fmt::format("[observer] {} has no use in a window observer, whose latent state is measurements; "
                                   "remove it",
                                   key));
    check_zero_start(o, "a window observer, which its first measurement fills,");
    if (experiment.training.gradient != LatentGradient::kAutomatic)
      throw KeyError("training.gradient",
                     "[training] gradient is of a latent system that learns, and a window does not; remove it");
  }

  bool adopt(Experiment& experiment, double) const override {
    ObserverConfig plain;
    plain.structure = name();
    plain.input_hold = experiment.observer.input_hold;
    experiment.observer = plain;
    experiment.training.eigenvalue_learning_rate = 0.0;
    experiment.training.gradient_clip = 0.0;
    experiment.training.transient = Transient::kKeep;
    return true;
  }

  void vary(Experiment& experiment, Draws& draws) const override {
    int& samples = experiment.observer.own.set<WindowConfig>().samples;
    samples = std::clamp(static_cast<int>(std::lround(samples * draws.one_of({0.5, 1.0, 1.0, 2.0, 4.0}))), 1, 1024);
  }

  void make(const Experiment& experiment, ObserverStructure& structure) const override {
    structure.latent.rows = structure.readings * experiment.observer.own.get<WindowConfig>().samples;
    for (int row = 0; row < structure.latent.rows; ++row) structure.features.push_back({.latent = row});
  }

  std::vector<float> initial_dynamics(const ObserverStructure&, const Experiment&) const override { return {}; }

  std::unique_ptr<LatentDynamics> latent_dynamics(const Experiment&, const ObserverStructure& structure,
                                                  const std::vector<double>& steps_s, int) const override {
    return std::make_unique<WindowLatent>(structure, steps_s);
  }

  void to_model(const ObserverStructure& structure, const float* parameters, const Experiment& experiment,
                const Dataset&, codegen::Model& model) const override {
    model.structure =
        codegen::Window{experiment.observer.own.get<WindowConfig>().samples, inverse_map_of(structure, parameters, 0)};
  }
};

}  // namespace

const TrainableStructure& window_structure() {
  static const WindowStructure kModule;
  return kModule;
}

}  // namespace nlo::trainer
