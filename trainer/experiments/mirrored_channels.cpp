// SPDX-License-Identifier: MIT
#include "trainer/experiments/mirrored_channels.h"

#include <string>

#include "codegen/model/computed_outputs.h"
#include "trainer/data/log_schema.h"
#include "trainer/data/mirror.h"
#include "trainer/plants/odd_plant.h"
#include "trainer/plants/plant_registry.h"

namespace nlo::trainer {
namespace {

/// Returns the odd columns, including computed outputs, whose sign follows from the channels that they are computed
/// from.
std::vector<std::string> odd_columns(const LogConfig& log) {
  std::vector<std::string> odd;
  for (const ColumnConfig& column : log.columns)
    if (column.odd && column.expression.empty() &&
        (column.role == ColumnRole::kOutput || column.role == ColumnRole::kInput || column.role == ColumnRole::kState))
      odd.push_back(column.name);
  const LogSchema schema = resolve_columns(log);
  std::vector<Channel> readings = schema.output_channels;
  readings.insert(readings.end(), schema.input_channels.begin(), schema.input_channels.end());
  const Mirror mirror = mirror_of(odd, readings, {});
  std::vector<codegen::Parity> parities(readings.size(), codegen::Parity::kEven);
  for (std::size_t row = 0; row < readings.size(); ++row)
    if (!mirror.none() && mirror.readings[row]) parities[row] = codegen::Parity::kOdd;
  const codegen::ComputedOutputs computed(schema.output_channels, schema.input_channels);
  for (std::size_t i = 0; i < computed.all().size(); ++i)
    if (computed.all()[i].parity(parities) == codegen::Parity::kOdd)
      odd.push_back(schema.output_channels[static_cast<std::size_t>(computed.first()) + i].name);
  return odd;
}

}  // namespace

std::vector<std::string> mirrored_channels(const Experiment& experiment) {
  if (!experiment.training.mirror) return {};
  if (experiment.log) return odd_columns(*experiment.log);
  return odd_channels(*make_plant(*experiment.plant), experiment.plant->even);
}

}  // namespace nlo::trainer
