// SPDX-License-Identifier: MIT
// nlo bound: Proposition 2 on a model's own plant, for its eigenvalues times k.
#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "codegen/model/model.h"
#include "codegen/model_file/model_file.h"
#include "trainer/base/number_text.h"
#include "trainer/base/printable.h"
#include "trainer/bounds/bound_study.h"
#include "trainer/bounds/bound_text.h"
#include "trainer/bounds/latent_system.h"
#include "trainer/commands/bounded_errors.h"
#include "trainer/commands/command.h"
#include "trainer/commands/directory_lock.h"
#include "trainer/commands/options.h"
#include "trainer/commands/output_directory.h"
#include "trainer/compare/strict_study.h"
#include "trainer/config/experiment.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/training_sets.h"
#include "trainer/jobs/kept_training.h"
#include "trainer/jobs/run_jobs.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/registry.h"
#include "trainer/report/pages.h"
#include "trainer/structures/linear_latent_start.h"
#include "trainer/training/train.h"

namespace nlo::trainer {
namespace {

/// `experiment` with k times the eigenvalues that `model` has learned, clocks k times as fast, and `steps` of training
/// (0: its own, at most 2,000). Throws codegen::Error when rk4 would diverge, or when the eigenvalues of several
/// outputs have been learned apart, which no experiment can hold.
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

/// Trains it on its own simulations and keeps that below `output`, if there is one; F stays that of `model`, which it
/// becomes. Throws codegen::Error when the training diverges.
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

struct BoundArguments {
  std::string model, factors = "1,2,4,8", noise, disturbance = "0", output;
  BoundTest test;
  int steps = 0;  ///< 0: the experiment's, at most 2,000
  bool json = false, csv = false, quiet = false;
};

std::vector<double> parse_factors(const std::string& text) {
  constexpr double kSmallest = 1e-3, kLargest = 1e3;
  constexpr std::size_t kMost = 32;
  std::vector<double> factors;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find(',', start), text.size());
    const std::string part = text.substr(start, end - start);
    const auto k = finite_number(part);
    if (!k || *k < kSmallest || *k > kLargest)
      throw codegen::Error(
          fmt::format("--k {}: \"{}\" is not a factor; write numbers from {} to {}, such as --k 1,2,4,8", text, part,
                      kSmallest, kLargest));
    factors.push_back(*k);
    start = end + 1;
  }
  std::sort(factors.begin(), factors.end());
  factors.erase(std::unique(factors.begin(), factors.end()), factors.end());
  if (factors.size() > kMost) throw codegen::Error(fmt::format("--k: at most {} factors", kMost));
  return factors;
}

void check_model(const codegen::Model& model, const Experiment& experiment, const std::string& path) {
  const auto refuse = [&](const std::string& why) { throw codegen::Error(fmt::format("{}: {}", path, why)); };
  if (!experiment.plant) refuse("was trained on logs; the bound needs a plant to compute T from: train on a [plant]");
  if (codegen::linear_latent(model) == nullptr || model.nu() > 0)
    refuse(fmt::format("is a {} observer; Proposition 2 is about KKL observers without inputs, structure \"kkl\"",
                       codegen::structure_name(model)));
  if (!PlantChannels(*experiment.plant, *make_plant(*experiment.plant)).plain())
    refuse("gives angles as sine and cosine, or leaves states out; the bound is about the plant's own states");
  for (const auto* channels : {&model.outputs, &model.states})
    for (const codegen::Channel& channel : *channels)
      if (channel.wrap != 0.0)
        refuse(channel.name + " is an angle that wraps; the bound needs a state space without turns");
}

BoundReport study(const BoundArguments& arguments, const codegen::Model& model, const Experiment& experiment,
                  const Plant& plant, const std::vector<double>& factors) {
  const BoundStudy bound(plant, model, experiment.simulation, arguments.test);
  BoundReport report{model.name, plant.name(),  bound.exact(), arguments.test, experiment.simulation.horizon_s,
                     {},         bound.affine()};
  const std::atomic<bool>& stop = stop_on_interrupt();
  std::vector<codegen::Model> observers(factors.size(), model);
  std::vector<std::string> origins(factors.size(), "the model's own");
  std::vector<Job> jobs;
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const double k = factors[i];
    if (bound.exact()) {
      observers[i] = bound.exact_observer(k);
      origins[i] = "pseudo-inverse of T";
    } else if (k != 1.0) {
      const Experiment again = scaled_experiment(experiment, model, k, arguments.steps);
      origins[i] = fmt::format("retrained, {} steps", again.training.steps);
      jobs.push_back({fmt::format("T* for k = {}", shortest_text(k)), 1.0,
                      [&, again, &observer = observers[i]](const JobContext& context) {
                        return train_scaled(again, arguments.output, context, observer);
                      }});
    }
  }
  {
    StatusLine line;
    JobsProgress progress(line);
    const JobsResult trained = run_jobs(
        jobs, {.threads = arguments.test.threads, .stop = &stop, .progress = arguments.quiet ? nullptr : &progress});
    trained.check();
    if (trained.left > 0)
      throw RunFailure(trained.interrupted_text(arguments.output.empty() ? "" : "the same command"));
  }
  for (std::size_t i = 0; i < factors.size(); ++i) {
    if (stop.load()) throw RunFailure("interrupted");
    report.results.push_back(bound.at(factors[i], observers[i], origins[i]));
    if (!arguments.quiet) fmt::print(stderr, "k = {}: done\n", shortest_text(factors[i]));
  }
  return report;
}

void run_bound(BoundArguments arguments) {
  const std::vector<double> factors = parse_factors(arguments.factors);
  arguments.test.disturbance = disturbance_limit(arguments.disturbance);
  const codegen::Model model = codegen::read_model(arguments.model);
  Experiment experiment = experiment_of(model, arguments.model);
  experiment.threads = arguments.test.threads;
  check_model(model, experiment, arguments.model);
  arguments.test.noise = noise_limit(arguments.noise, experiment.training.noise);
  for (const double k : factors) scaled_experiment(experiment, model, k, arguments.steps);  // its refusals come first
  if (is_stdout(arguments.output))
    throw codegen::Error(
        "-o -: bound.html and bound.csv are two files, and stdout is one; leave -o out: the result is on stdout, with "
        "--csv or --json in that form");
  if (!arguments.output.empty()) check_output_directory({arguments.output, false, true}, model.name);
  const auto plant = make_plant(*experiment.plant);

  run_phase([&] {
    DirectoryLock lock;
    if (!arguments.output.empty()) {
      make_output_directory(arguments.output);
      lock.take(arguments.output);
    }
    const BoundReport report = study(arguments, model, experiment, *plant, factors);
    fmt::print("{}", arguments.json  ? bound_json(report)
                     : arguments.csv ? bound_csv(report)
                                     : printable(bound_text(report)));
    if (!arguments.output.empty()) {
      codegen::write_file_atomically(arguments.output + "/bound.csv", bound_csv(report));
      codegen::write_file_atomically(arguments.output + "/bound.html", bound_page(report));
      if (!arguments.json && !arguments.csv)
        fmt::print("table    {0}/bound.csv\nreport   {0}/bound.html\n", arguments.output);
    }
    if (const std::string broken = broken_bound(report); !broken.empty())
      throw RunFailure(
          fmt::format("the measured error exceeds a proven bound for {}: a defect of this program", broken));
  });
}

}  // namespace

void add_bound(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<BoundArguments>();
  CLI::App* command =
      app.add_subcommand("bound", "Trade speed against noise: the robustness bound for faster and slower eigenvalues");
  Options options(*command);
  options.value("MODEL", arguments->model, "model.json of nlo train, trained on a plant")->required();
  options.shown("--k", arguments->factors, "factors for all eigenvalues, separated by commas", "K,K,...");
  options.value("--noise", arguments->noise,
                "bounded noise: uniform:HALF_WIDTH or none (default: uniform, as strong as in training)");
  options.shown("--disturbance", arguments->disturbance, "largest |w| on the state's derivative", "W");
  options.number("--trajectories", arguments->test.trajectories, 1, 10000, "number of measured runs");
  options
      .value("--steps", arguments->steps,
             "training steps of T* for each k except 1 (default: the experiment's, at most 2000)")
      ->check(CLI::Range(1, 100000000));
  options.seed(arguments->test.seed, "seed of the initial states, the noise and the disturbance");
  options
      .value("--boxes", arguments->test.boxes,
             "most boxes in the search for the Lipschitz constant of T* (default: as many as take some 2 s)")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{100000000}));
  options.threads(arguments->test.threads);
  options.directory("-o,--output", arguments->output, "directory for bound.html and bound.csv");
  CLI::Option* json = options.flag("--json", arguments->json, "one JSON object instead of the table");
  options.flag("--csv", arguments->csv, "CSV instead of the table")->excludes(json);
  options.flag("-q,--quiet", arguments->quiet, "no progress on stderr");
  command->footer(
      "With -o trainings are kept in DIR/retrained: the same k and steps train nothing again.\n"
      "Examples:\n"
      "  nlo bound runs/van_der_pol/model.json --k 1,2,4,8 --noise uniform:0.5 -o runs/van_der_pol\n"
      "  nlo bound runs/van_der_pol/model.json --k 0.5,1,2 --disturbance 0.05 --steps 4000 --json");
  command->callback([arguments, &action] { action = [arguments] { run_bound(*arguments); }; });
}

}  // namespace nlo::trainer
