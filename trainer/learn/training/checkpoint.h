// SPDX-License-Identifier: MIT
// The state from which a training run continues to the same bytes: parameters, the optimiser's memory, the average, the
// best model so far and the metrics. Random numbers carry no state (random.h).
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
  std::int64_t step = 0;   ///< steps done
  double elapsed_s = 0.0;  ///< over all sessions
  double best_rmse = 0.0;  ///< error of `best` on the validation set
  std::vector<float> parameters, memory, average, best;
  std::vector<MetricsRow> metrics;
};

/// Which training a checkpoint has to belong to. A checksum tells a damaged file from a whole one, not a forged one:
/// every size is compared with the experiment's before it is used.
struct CheckpointOwner {
  std::uint64_t fingerprint = 0;  ///< hash of experiment and data
  std::size_t parameters = 0;     ///< also of the average and of the best
  std::size_t memory = 0;         ///< numbers that the optimiser keeps
  std::size_t eigenvalues = 0;    ///< in each row of the metrics
  std::int64_t steps = 0;         ///< training.steps
};

/// Replaces the file atomically. `fingerprint` names experiment and data.
void write_checkpoint(const TrainingState& state, std::uint64_t fingerprint, const std::string& path);

/// Throws codegen::InputError when the file is damaged, from another version, of another experiment or data, or when
/// more steps are done in it than are asked for. What it returns has the owner's sizes, a row of metrics or more, in
/// the order of their steps, and a finite best; parameters may hold anything, for a training that diverged is kept too.
TrainingState read_checkpoint(const std::string& path, const CheckpointOwner& owner);

/// Whether a training can be resumed there: a folder's checkpoint.bin.
bool has_checkpoint(const std::string& directory);

/// metrics.csv: step,elapsed_s,loss,train_rmse,validation_rmse,learning_rate,lambda_1_re,lambda_1_im,...
std::string metrics_csv(const std::vector<MetricsRow>& rows, int pairs);

/// FNV-1a, 64 bit.
std::uint64_t fingerprint(const void* data, std::size_t bytes, std::uint64_t start = 0xcbf29ce484222325ULL);

}  // namespace nlo::trainer
