// SPDX-License-Identifier: MIT
#include "trainer/experiments/symmetries.h"

#include <algorithm>
#include <string>

#include "codegen/model/computed_outputs.h"
#include "trainer/data/log_schema.h"
#include "trainer/plants/plant_symmetry.h"
#include "trainer/plants/registry.h"

namespace nlo::trainer {
namespace {

/// Of logs, computed outputs included: theirs follows from what they are computed of.
SymmetryConfig mirror_of_columns(const LogConfig& log) {
  SymmetryConfig mirror{.kind = "sign"};
  for (const ColumnConfig& column : log.columns)
    if (column.odd && column.expression.empty() &&
        (column.role == ColumnRole::kOutput || column.role == ColumnRole::kInput || column.role == ColumnRole::kState))
      mirror.channels.push_back(column.name);
  const LogSchema schema = resolve_columns(log);
  std::vector<Channel> readings = schema.output_channels;
  readings.insert(readings.end(), schema.input_channels.begin(), schema.input_channels.end());
  std::vector<codegen::Parity> parities(readings.size(), codegen::Parity::kEven);
  for (const std::vector<int>& odd : on_channels(mirror, readings, {}).readings.vectors)
    parities[static_cast<std::size_t>(odd.front())] = codegen::Parity::kOdd;
  const codegen::ComputedOutputs computed(schema.output_channels, schema.input_channels);
  for (std::size_t i = 0; i < computed.all().size(); ++i)
    if (computed.all()[i].parity(parities) == codegen::Parity::kOdd)
      mirror.channels.push_back(schema.output_channels[static_cast<std::size_t>(computed.first()) + i].name);
  return mirror;
}

}  // namespace

SymmetryConfig mirror_symmetry(const Experiment& experiment) {
  if (experiment.log) return mirror_of_columns(*experiment.log);
  return odd_symmetry(*make_plant(*experiment.plant), experiment.plant->even);
}

std::vector<SymmetryConfig> symmetries_of(const Experiment& experiment) {
  std::vector<SymmetryConfig> all;
  if (experiment.training.mirror) all.push_back(mirror_symmetry(experiment));
  std::ranges::copy_if(experiment.symmetries, std::back_inserter(all),
                       [](const SymmetryConfig& symmetry) { return !symmetry.by_construction; });
  return all;
}

}  // namespace nlo::trainer
