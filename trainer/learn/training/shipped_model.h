// SPDX-License-Identifier: MIT
// What ships of a training: the model at its best step, with what its states read chosen (readout.h), its facts, and an
// error head where it has one.
#pragma once

#include <cstdint>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/learn/training/checkpoint.h"
#include "trainer/learn/training/objective.h"
#include "trainer/learn/training/readout.h"
#include "trainer/learn/training/train.h"

namespace nlo::trainer {

/// A training at its end.
struct TrainingEnd {
  const Experiment& experiment;
  const Dataset& dataset;
  const TrainOptions& options;
  const ObserverStructure& structure;
  const codegen::SensorFailures& failures;
  const TrainingState& state;
  std::uint64_t data_hash;
};

struct ShippedModel {
  codegen::Model model;
  Readout readout;                     ///< empty unless selects_readout()
  std::vector<LeftOutGroup> left_out;  ///< see TrainingResult
  double validation_rmse = 0.0;        ///< of the model as it ships, on validation data, in the units of the loss
};

bool selects_readout(const Experiment& experiment);

/// `objective`: on the training data; `validator`: on the validation data.
ShippedModel shipped_model(const TrainingEnd& training, Objective& objective, Objective& validator, ThreadPool& pool);

}  // namespace nlo::trainer
