// SPDX-License-Identifier: MIT
// The state from which a training continues to the same bytes: parameters, the optimiser's memory, the average, the
// best model so far and the metrics. Random numbers have no state (random.h).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace nlo::trainer {

/// One line of metrics.csv.
struct MetricsRow {
  std::int64_t step = 0;
  double elapsed_s = 0.0;
  double loss = 0.0;
  double train_rmse = 0.0;
  double validation_rmse = 0.0;
  double learning_rate = 0.0;
  std::vector<double> eigenvalues;  ///< n_z
};

struct TrainingState {
  std::int64_t step = 0;          ///< number of finished steps
  double elapsed_s = 0.0;         ///< sum over all sessions
  double best_rmse = 0.0;         ///< error of `best` on the validation set
  std::int64_t returned_at = -1;  ///< step at which training ran away the last time and returned to `best`; -1: never
  std::vector<float> parameters, memory, average, best;
  std::vector<MetricsRow> metrics;
};

/// The training to which a checkpoint must belong. Its checksum detects a damaged file but not a forged one, so every
/// size is compared with the experiment's before it is used.
struct CheckpointOwner {
  std::uint64_t fingerprint = 0;  ///< hash of experiment and data
  std::size_t parameters = 0;     ///< number of parameters; the average and the best model have as many
  std::size_t memory = 0;         ///< number of values that the optimiser stores
  std::size_t eigenvalues = 0;    ///< number in each row of the metrics
  std::int64_t steps = 0;         ///< training.steps
};

/// Replaces the file atomically. `fingerprint` is the hash of experiment and data.
void write_checkpoint(const TrainingState& state, std::uint64_t fingerprint, const std::string& path);

/// Reads a checkpoint. Throws codegen::InputError if the file is damaged, has another version, belongs to another
/// experiment or data, or has more finished steps than the experiment asks for. The result has the sizes of the owner,
/// at least one row of metrics, rows in the order of their steps, and a finite best error. Its parameters may be any
/// numbers, because a diverged training is kept, too.
TrainingState read_checkpoint(const std::string& path, const CheckpointOwner& owner);

/// Returns true if the folder has a checkpoint.bin, so that a training can be resumed there.
bool has_checkpoint(const std::string& directory);

/// Returns metrics.csv: step,elapsed_s,loss,train_rmse,validation_rmse,learning_rate,lambda_1_re,lambda_1_im,...
std::string metrics_csv(const std::vector<MetricsRow>& rows, int pairs);

/// Returns the hash by FNV-1a with 64 bits.
std::uint64_t fingerprint(const void* data, std::size_t bytes, std::uint64_t start = 0xcbf29ce484222325ULL);

}  // namespace nlo::trainer
