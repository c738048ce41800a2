// SPDX-License-Identifier: MIT
// What a training run must remember to go on to the same bytes: parameters, the optimiser's memory, the average, the
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
  double best_rmse = 0.0;  ///< of `best`, on the validation set
  std::vector<float> parameters, memory, average, best;
  std::vector<MetricsRow> metrics;
};

/// Replaces the file atomically. `fingerprint` names experiment and data.
void write_checkpoint(const TrainingState& state, std::uint64_t fingerprint, const std::string& path);

/// Throws codegen::Error when the file is damaged, from another version, or of another experiment or data.
TrainingState read_checkpoint(const std::string& path, std::uint64_t fingerprint);

/// metrics.csv: step,elapsed_s,loss,train_rmse,validation_rmse,learning_rate,lambda_1_re,lambda_1_im,...
std::string metrics_csv(const std::vector<MetricsRow>& rows, int pairs);

/// FNV-1a, 64 bit.
std::uint64_t fingerprint(const void* data, std::size_t bytes, std::uint64_t start = 0xcbf29ce484222325ULL);

}  // namespace nlo::trainer
