// SPDX-License-Identifier: MIT
#include "trainer/commands/scaled_training.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/base/number_text.h"
#include "trainer/bounds/latent_system.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/training_sets.h"
#include "trainer/structures/linear_latent_start.h"
#include "trainer/training/train.h"

namespace nlo::trainer {
Experiment scaled_experiment(const Experiment& experiment, const codegen::Model& model, double k, int steps) {
  constexpr int kShort = 2000;  // the eigenvalues stand still: T* alone is learned
  constexpr double kSame = 1e-6;
  Experiment again = experiment;
  ObserverConfig& observer = again.observer;
  const std::size_t outputs = static_cast<std::size_t>(model.nr()), pairs = observer.pairs.size(),
                    real = observer.eigenvalues.size();
  const auto expected = outputs * (2 * pairs + real) + observer.clocks_s.size();
  if (static_cast<std::size_t>(model.nz()) != expected ||
      static_cast<std::size_t>(codegen::linear_latent(model)->pairs) != outputs * pairs)
    throw codegen::Error(
        fmt::format("model {}: has {} latent states, but its config describes {}; the file was changed: train it again",
                    model.name, model.nz(), expected));
  // As make_structure() lays them out: the pairs of each output, then the real ones of each output, then the clocks.
  const auto learned = [&](std::size_t first, std::size_t per_output, std::size_t i) {
    const double value = codegen::linear_latent(model)->eigenvalues(static_cast<Eigen::Index>(first + i));
    for (std::size_t j = 1; j < outputs; ++j) {
      const double other =
          codegen::linear_latent(model)->eigenvalues(static_cast<Eigen::Index>(first + j * per_output + i));
      if (std::abs(other - value) > kSame * std::abs(value))
        throw codegen::Error(
            fmt::format("model {}: its outputs have learned different eigenvalues ({:.6g} and {:.6g}), which cannot be "
                        "trained again "
                        "as one set; train it with learn_eigenvalues = false, or ask for --k 1 alone",
                        model.name, value, other));
    }
    return k * value;
  };
  if (k != 1.0) {
    for (std::size_t i = 0; i < pairs; ++i)
      observer.pairs[i] = {learned(0, 2 * pairs, 2 * i), learned(0, 2 * pairs, 2 * i + 1)};
    for (std::size_t i = 0; i < real; ++i) observer.eigenvalues[i] = learned(2 * pairs * outputs, real, i);
    for (double& tau_s : observer.clocks_s) tau_s /= k;
  }
  observer.learn_eigenvalues = false;
  again.training.steps = steps > 0 ? steps : std::min(experiment.training.steps, kShort);
  try {
    check_latent_step(observer, again.simulation.sample_period_s);
  } catch (const codegen::Error& error) {
    throw codegen::Error(fmt::format("k = {}: {}", shortest_text(k), error.what()));
  }
  again.source_text = format_experiment(again);
  return again;
}

JobEnd train_scaled(const Experiment& experiment, const std::string& output, const JobContext& context,
                    codegen::Model& model) {
  const codegen::Model original = std::move(model);
  const FinishedRun inputs{run_identity(experiment)};
  const Train train_it = [&](const TrainOptions& options) {
    Experiment own = experiment;
    own.threads = context.threads;
    const TrainingSets sets = simulate_training_sets(own);
    return train(own, sets.training, sets.validation, options);
  };
  const JobEnd end =
      train_kept(output.empty() ? "" : kept_folder(output + "/retrained", inputs), inputs, context, train_it, model);
  if (end != JobEnd::kStopped)
    model = with_injection(std::move(model), codegen::linear_latent(original)->output_injection);
  return end;
}

}  // namespace nlo::trainer
