// SPDX-License-Identifier: MIT
// The training loop: steps, schedule, averaging, validation, checkpoints. The same experiment, seed and data give the
// same model, byte for byte, for any number of threads and however often the run was interrupted and resumed.
#pragma once

#include <atomic>
#include <cmath>
#include <complex>
#include <functional>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/learn/training/checkpoint.h"
#include "trainer/learn/training/readout.h"
#include "trainer/learn/uncertainty/calibration.h"

namespace nlo::trainer {

struct TrainProgress {
  long step = 0, steps = 0;
  double loss = 0.0, rmse = 0.0;  ///< rmse: latest error on the validation set
  std::vector<std::complex<double>> eigenvalues;
  double steps_per_s = 0.0, elapsed_s = 0.0, left_s = 0.0;
};

/// A group of logs that a training leaves out.
struct LeftOutLogs {
  std::string kind;  ///< log_files.h
  Dataset logs;
};

/// Errors that a training has on a group of logs which was left out of it.
struct LeftOutGroup {
  JudgedSet squares;   ///< squared errors of the trained T*, and of the rows beside it
  ErrorScores scores;  ///< scores of the shipped model's error head, if any
};

/// Facts for the provenance of the shipped model that only the caller knows. An empty text is left out.
struct KnownFacts {
  std::string ignored_inputs;  ///< names of the plant's inputs that the observer is not given
  std::string input_delay;     ///< delay of each input in flight; recorded if the model reads inputs
  std::string training_logs;   ///< TrainingLogs as text
};

/// Errors on validation data before and after a time t_c since the start of a run. Each state's error is divided by its
/// standard deviation and squared; an error here is the root of the mean, over the samples, of the sum over the states.
struct SplitError {
  double transient = 0.0;
  double settled = 0.0;
  /// Returns the geometric mean, so that a relative change counts equally in both errors. In an arithmetic mean, the
  /// larger transient error would hide the settled error.
  double both() const { return std::sqrt(transient * settled); }
};

struct TrainOptions {
  std::string directory;  ///< folder of checkpoint.bin and metrics.csv; empty: nothing is written
  bool resume = false;    ///< continue from the checkpoint of the directory
  std::function<void(const TrainProgress&)> progress;  ///< called after each step, unless it is empty
  const std::atomic<bool>* stop = nullptr;             ///< when true: save, and return as interrupted
  /// Groups of logs that are left out of the training. TrainingResult::left_out has the errors on them.
  std::vector<LeftOutLogs> left_out = {};
  /// Errors of trainings that left out logs. They select the readouts (shipped_model.h) and set the size of the error
  /// head.
  std::vector<LeftOutGroup> evidence = {};
  KnownFacts facts = {};
  /// t_c [s] of TrainingResult::split and of the choice of readouts. 0: no split is computed; the choice uses the t_c
  /// of the evaluation.
  double settled_from_s = 0.0;
};

enum class TrainOutcome {
  kFinished,
  kInterrupted,
  kDiverged,    ///< stopped early: a number was not finite, or the loss grew without bounds
  kClosedForm,  ///< ran to its end; nothing failed, and the closed form that it started from is best: see no_progress.h
  kNoProgress,  ///< ran to its end without improving its start: see no_progress.h
  kBelowFloor   ///< ran to its end, but a state has a larger error than a simple estimate: see readout.h
};

struct TrainingResult {
  TrainOutcome outcome = TrainOutcome::kFinished;
  /// Returns true if the training succeeded: it was not interrupted, did not diverge, made progress, and no state is
  /// below the floor.
  bool succeeded() const { return outcome == TrainOutcome::kFinished || outcome == TrainOutcome::kClosedForm; }
  codegen::Model model;                ///< the model with the lowest validation error so far
  Readout readout;                     ///< the readouts of its states, and the alternatives
  std::size_t groups = 0;              ///< number of left-out groups that selected `readout`; 0: its own data did
  std::vector<LeftOutGroup> left_out;  ///< errors on TrainOptions::left_out; groups without truth are omitted
  std::vector<MetricsRow> metrics;
  long steps_done = 0;
  double elapsed_s = 0.0;
  double validation_rmse = 0.0;  ///< error of `model`
  SplitError split;              ///< errors of `model`, if TrainOptions::settled_from_s is set
  std::string message;           ///< if the outcome is not kFinished: the reason and the remedy
  int returns = 0;  ///< number of times that training ran away and continued from its best model (if gradients are
                    ///< clipped)
};

/// Trains on `training` and selects the model with the smallest error on `validation` (with the training noise). Throws
/// codegen::Error if the experiment cannot be trained, for example on no trajectories.
TrainingResult train(const Experiment& experiment, const Dataset& training, const Dataset& validation,
                     const TrainOptions& options);

}  // namespace nlo::trainer
