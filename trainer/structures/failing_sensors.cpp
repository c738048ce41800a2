// SPDX-License-Identifier: MIT
#include "trainer/structures/failing_sensors.h"

#include <fmt/format.h>

#include <algorithm>

#include "trainer/config/key_error.h"
#include "trainer/config/keys.h"

namespace nlo::trainer {
namespace {

struct FailingSensors {
  std::vector<std::string> may_fail = {};
  double staleness_s = 1.0;
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

}  // namespace

std::vector<Key<ObserverConfig>> failing_sensor_keys() {
  return {own_key<ObserverConfig>(key("may_fail", &FailingSensors::may_fail, identifiers(),
                                      "kkl, gated: outputs that may be missing; the observer continues without them")),
          own_key<ObserverConfig>(key("staleness_s", &FailingSensors::staleness_s, positive(),
                                      "kkl, gated: time constant with which a missing output decays to its mean [s]"))};
}

bool has_failing_sensors(const ObserverConfig& observer) {
  return !observer.own.get<FailingSensors>().may_fail.empty();
}

ObserverConfig plain_observer_of(std::string_view structure, const ObserverConfig& other) {
  ObserverConfig observer;
  observer.structure = structure;
  observer.input_hold = other.input_hold;
  observer.own.set<FailingSensors>() = other.own.get<FailingSensors>();
  return observer;
}

void check_failing_sensors(const Experiment& experiment, const ChannelCounts& channels) {
  const auto& names = experiment.observer.own.get<FailingSensors>().may_fail;
  const auto fail = [](const std::string& what) { throw KeyError("observer.may_fail", "[observer] may_fail " + what); };
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::size_t output = index_of(names[i], channels.output_channels);
    if (output == channels.output_channels.size())
      fail(fmt::format("names \"{}\", which is not an output; the outputs are: {}", names[i],
                       names_of(channels.output_channels)));
    if (!channels.output_channels[output].expression.empty())
      fail(fmt::format("names \"{}\", which is computed; name the outputs from which it is computed", names[i]));
    if (channels.output_channels[output].wrap > 0.0)
      fail(fmt::format("names the angle \"{}\", which has no mean to which it could decay; remove it", names[i]));
    if (std::count(names.begin(), names.end(), names[i]) > 1)
      fail(fmt::format("names \"{}\" twice; remove one", names[i]));
  }
  if (names.size() == static_cast<std::size_t>(codegen::measured_outputs(channels.output_channels)) &&
      experiment.training.dropout > 0.0)
    fail(
        "names every output, so that no measurement is left; remove one, or, if samples are only lost occasionally, "
        "set [training] dropout = 0 and a noise with +missing");
}

codegen::SensorFailures failing_sensors(const Experiment& experiment, const Dataset& training) {
  const FailingSensors& own = experiment.observer.own.get<FailingSensors>();
  codegen::SensorFailures failures{.outputs = {}, .rest = {}, .staleness_s = own.staleness_s};
  for (const std::string& name : own.may_fail)
    failures.outputs.push_back(static_cast<int>(index_of(name, training.outputs)));
  std::sort(failures.outputs.begin(), failures.outputs.end());
  const codegen::ComputedOutputs computed(training.outputs, training.inputs_read());
  for (std::size_t i = 0; i < computed.all().size(); ++i) {
    const std::vector<int>& parts = computed.all()[i].reads();
    const bool fails = std::any_of(parts.begin(), parts.end(), [&](int part) {
      return std::find(failures.outputs.begin(), failures.outputs.end(), part) != failures.outputs.end();
    });
    if (fails) failures.outputs.push_back(computed.first() + static_cast<int>(i));
  }
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(training.readings().size()));
  double count = 0.0;
  for (const Trajectory& run : training.trajectories) {
    for (Eigen::Index j = 0; j < run.outputs.rows(); ++j) sum(j) += run.outputs.row(j).sum();
    count += static_cast<double>(run.samples());
  }
  Eigen::VectorXd mean = sum / std::max(count, 1.0);
  for (Eigen::Index row = 0; row < mean.size(); ++row)  // mean over runs and their mirror images
    if (!training.mirror.none() && training.mirror.readings[static_cast<std::size_t>(row)]) mean(row) = 0.0;
  failures.rest = mean(failures.outputs);
  return failures;
}

}  // namespace nlo::trainer
