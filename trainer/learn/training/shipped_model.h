// SPDX-License-Identifier: MIT
// Chooses the shipped model of a training, in this order:
//   1. the parameters: those of the lowest validation error of all steps
//   2. the readout of each state: T* as trained, a linear row, or a blend of both,
//        x_hat_i = share T*_i + (1 - share) w_i . [1; u; y]
//      The readout with the smallest error on logs that were left out of trainings like this one (left_out.h) is used.
//      Without such logs, the larger error on training data or validation data counts. The error is the geometric mean
//      of the RMSE before and after the end of the transient. The row is fitted on the features of the parameters of 1.
//      So on this data an observer is not worse than the linear row, a constant, or a sensor of that state.
//   3. the facts of its provenance
//   4. an error head, if the experiment asks for one
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
  Readout readout;                     ///< empty unless is_chosen()
  std::vector<LeftOutGroup> left_out;  ///< see TrainingResult
  double validation_rmse = 0.0;        ///< error of the shipped model on validation data, in the units of the loss
  SplitError split;                    ///< see TrainingResult
};

/// Returns the end of the transient [sample periods since the start], as in the evaluation of the experiment.
double settled_from(const Experiment& experiment, const Dataset& dataset, const TrainOptions& options);

/// Returns the shipped model. `objective` has the training data, `validator` the validation data. A linear row may read
/// outputs and inputs that T* does not read, but angles only in the form that T* reads. If z is the estimate, every
/// state keeps it; the errors of the rows are reported nevertheless.
ShippedModel shipped_model(const TrainingEnd& training, Objective& objective, Objective& validator, ThreadPool& pool);

}  // namespace nlo::trainer
