// SPDX-License-Identifier: MIT
// KKL observer (16): z' = D z + F y, x_hat = T*(z). The eigenvalues of D are learned with T*. Its sensors may fail.
#include <fmt/format.h>

#include <algorithm>

#include "trainer/config/key_error.h"
#include "trainer/config/keys.h"
#include "trainer/structures/kkl_family.h"

namespace nlo::trainer {
namespace {

/// Keys of [observer] that this structure alone has.
struct KklConfig {
  std::vector<std::string> may_fail = {};
  double staleness_s = 1.0;
  double saturation = 0.0;
};

std::size_t index_of(const std::string& name, const std::vector<codegen::Channel>& outputs) {
  const auto found =
      std::find_if(outputs.begin(), outputs.end(), [&](const auto& output) { return output.name == name; });
  return static_cast<std::size_t>(found - outputs.begin());
}

std::string names_of(const std::vector<codegen::Channel>& channels) {
  std::string text;
  for (const codegen::Channel& channel : channels) text += (text.empty() ? "" : ", ") + channel.name;
  return text;
}

class Kkl final : public KklFamily {
 public:
  std::string_view name() const override { return "kkl"; }

  std::vector<Key<ObserverConfig>> own_keys() const override {
    return {own_key<ObserverConfig>(key("may_fail", &KklConfig::may_fail, identifiers(),
                                        "kkl: outputs that may be missing; the model runs without any of them")),
            own_key<ObserverConfig>(key("staleness_s", &KklConfig::staleness_s, positive(),
                                        "kkl: a missing output fades by this time constant to its mean [s]")),
            own_key<ObserverConfig>(
                key("saturation", &KklConfig::saturation, at_least(0),
                    "kkl: T* follows z this many half ranges beyond its domain, no further; 0: wherever z "
                    "goes"))};
  }

  void check(const Experiment& experiment, const ChannelCounts& channels) const override {
    KklFamily::check(experiment, channels);
    const auto& names = experiment.observer.own.get<KklConfig>().may_fail;
    const auto fail = [](const std::string& what) {
      throw KeyError("observer.may_fail", "[observer] may_fail " + what);
    };
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::size_t output = index_of(names[i], channels.output_channels);
      if (output == channels.output_channels.size())
        fail(fmt::format("names \"{}\", which is no output; there is: {}", names[i],
                         names_of(channels.output_channels)));
      if (channels.output_channels[output].wrap > 0.0)
        fail(fmt::format("names the angle \"{}\", and what wraps has no place to fade to; leave it out", names[i]));
      if (std::count(names.begin(), names.end(), names[i]) > 1)
        fail(fmt::format("names \"{}\" twice; remove one", names[i]));
    }
    if (names.size() == channels.output_channels.size())
      fail("names every output, and nothing is left to observe by; leave one out");
  }

  codegen::SensorFailures failures(const Experiment& experiment, const Dataset& training) const override {
    const KklConfig& own = experiment.observer.own.get<KklConfig>();
    codegen::SensorFailures failures{.outputs = {}, .rest = {}, .staleness_s = own.staleness_s};
    for (const std::string& name : own.may_fail)
      failures.outputs.push_back(static_cast<int>(index_of(name, training.outputs)));
    std::sort(failures.outputs.begin(), failures.outputs.end());
    failures.rest = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(failures.outputs.size()));
    for (std::size_t i = 0; i < failures.outputs.size(); ++i) {
      const auto output = static_cast<std::size_t>(failures.outputs[i]);
      if (experiment.training.mirror && training.mirror.output(output) < 0.0) continue;  // as often below zero as above
      double sum = 0.0, count = 0.0;
      for (const Trajectory& run : training.trajectories) {
        sum += run.outputs.row(static_cast<Eigen::Index>(output)).sum();
        count += static_cast<double>(run.samples());
      }
      failures.rest(static_cast<Eigen::Index>(i)) = sum / std::max(count, 1.0);
    }
    return failures;
  }

  void to_model(const ObserverStructure& structure, const float* parameters, const Experiment& experiment,
                const Dataset&, codegen::Model& model) const override {
    model.structure = kkl_of(structure, parameters, experiment.observer, model);
    model.saturation = experiment.observer.own.get<KklConfig>().saturation;
  }
};

}  // namespace

const TrainableStructure& kkl_structure() {
  static const Kkl kModule;
  return kModule;
}

}  // namespace nlo::trainer
