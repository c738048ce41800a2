// SPDX-License-Identifier: MIT
#include "tests/claims/flight.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "codegen/base/file.h"
#include "codegen/model_file/model_file.h"
#include "trainer/base/printable.h"
#include "trainer/config/experiment.h"
#include "trainer/data/log_dataset.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/plants/excitation.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate.h"

namespace nlo::claims {

namespace {

using trainer::Dataset;
using trainer::Trajectory;

constexpr int kRuns = 8;
constexpr unsigned long long kSeed = 1;

/// The flown runs: true states and measurements.
struct Flights {
  Dataset truth;
  std::vector<Eigen::MatrixXd> measured;
};

Flights flights(const Experiment& experiment, const trainer::Experiment& config, const std::string& data) {
  Flights result;
  if (config.log) {
    result.truth = trainer::load_log_splits(*config.log, data).test;
    for (const Trajectory& run : result.truth.trajectories) result.measured.push_back(run.outputs);
    return result;
  }
  const auto plant = trainer::make_plant(*config.plant);
  const auto noise = trainer::parse_noise(experiment.flight_noise);
  result.truth =
      trainer::simulate(*plant, config.simulation, trainer::initial_state_seed(kSeed, trainer::SeedStream::kTest),
                        kRuns, 1.0, trainer::parse_excitation(*plant, experiment.flight_inputs));
  for (std::size_t i = 0; i < result.truth.trajectories.size(); ++i)
    result.measured.push_back(trainer::MeasurementNoise(noise, kSeed, i).on(result.truth.trajectories[i].outputs));
  return result;
}

/// Returns one line per sample for fly.cpp.
std::string lines_of(const Dataset& set, const Trajectory& run, const Eigen::MatrixXd& measured, Eigen::Index inputs) {
  std::string text;
  for (Eigen::Index k = 0; k < run.samples(); ++k) {
    text += fmt::format("{:.9g}", set.uniform || k == 0 ? 0.0 : run.time_s(k) - run.time_s(k - 1));
    for (Eigen::Index j = 0; j < codegen::measured_outputs(set.outputs); ++j) {
      const double wrap = set.outputs[static_cast<std::size_t>(j)].wrap;
      text += fmt::format(" {:.9g}", wrap > 0.0 ? std::remainder(measured(j, k), wrap) : measured(j, k));
    }
    for (Eigen::Index i = 0; i < inputs; ++i)
      text += fmt::format(" {:.9g}", run.inputs.size() > 0 ? run.inputs(i, k) : 0.0);
    text += '\n';
  }
  return text;
}

std::string program_for(const std::string& directory, const Tools& tools, const std::string& name) {
  const std::string header = directory + "/" + name + ".h", program = directory + "/fly";
  (void)output_of(fmt::format("{} export {} -o {}", trainer::shell_word(tools.nlo),
                              trainer::shell_word(directory + "/model.json"), trainer::shell_word(header)),
                  directory + "/export.log");
  (void)output_of(
      fmt::format("{} -std=c++20 -O2 -I {} -DNLO_HEADER='\"{}\"' -DNLO_MODEL={} {} -o {}",
                  trainer::shell_word(tools.compiler), trainer::shell_word(tools.runtime), header, name,
                  trainer::shell_word(tools.source + "/tests/claims/fly.cpp"), trainer::shell_word(program)),
      directory + "/compile.log");
  return program;
}

double error_of(double truth, double estimate, double wrap) {
  return wrap > 0.0 ? std::remainder(truth - estimate, wrap) : truth - estimate;
}

}  // namespace

std::string output_of(const std::string& command, const std::string& log) {
  const std::string out = log + ".out";
  std::string all = fmt::format("{} >{} 2>{}", command, trainer::shell_word(out), trainer::shell_word(log));
  char shell[] = "sh", option[] = "-c", *const arguments[] = {shell, option, all.data(), nullptr};
  pid_t child = 0;
  int status = -1;
  if (::posix_spawn(&child, "/bin/sh", nullptr, nullptr, arguments, environ) == 0)  // std::system() would ignore Ctrl-C
    ::waitpid(child, &status, 0);
  if (status != 0) {
    const std::string said = codegen::read_file(log);
    throw std::runtime_error(fmt::format("{}\n  exit {}: {}", command, WIFEXITED(status) ? WEXITSTATUS(status) : -1,
                                         said.substr(said.size() > 2000 ? said.size() - 2000 : 0)));
  }
  return codegen::read_file(out);
}

std::map<std::string, double> fly(const Experiment& experiment, const std::string& directory, const std::string& data,
                                  const Tools& tools) {
  const codegen::Model model = codegen::read_model(directory + "/model.json");
  const auto config_text = std::find_if(model.provenance.begin(), model.provenance.end(),
                                        [](const auto& fact) { return fact.first == "config"; });
  const trainer::Experiment config = trainer::parse_experiment(config_text->second, "provenance");
  const Flights all = flights(experiment, config, data);
  if (all.truth.trajectories.empty()) throw std::runtime_error(experiment.id + ": there is no test run to fly over");
  const std::string program = program_for(directory, tools, model.name);
  const trainer::Estimator judged = trainer::observer_estimator(model, all.truth.uniform)();

  const auto nx = static_cast<Eigen::Index>(model.states.size());
  Eigen::VectorXd lowest = Eigen::VectorXd::Constant(nx, HUGE_VAL), highest = -lowest;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(nx), power = squares, apart = squares;
  for (const Trajectory& run : all.truth.trajectories)
    for (Eigen::Index k = 0; k < run.samples(); ++k)
      if (run.weight(k) > 0.0) {
        lowest = lowest.cwiseMin(run.states.col(k));
        highest = highest.cwiseMax(run.states.col(k));
      }
  double samples = 0.0, scored = 0.0, in_domain = 0.0, ok = 0.0, runs = 0.0, first_in_domain = 0.0,
         first_in_range = 0.0;
  for (std::size_t i = 0; i < all.truth.trajectories.size(); ++i) {
    const Trajectory& run = all.truth.trajectories[i];
    const std::string in = fmt::format("{}/flight_{}.txt", directory, i + 1);
    codegen::write_file_atomically(in, lines_of(all.truth, run, all.measured[i], model.nu()));
    std::istringstream flown(output_of(fmt::format("{} <{}", trainer::shell_word(program), trainer::shell_word(in)),
                                       directory + "/flight.log"));
    const Eigen::MatrixXd reference = judged(all.measured[i], run.inputs, run.time_s).x_hat;
    Eigen::VectorXd x_hat(nx);
    int status = 0, inside = 0;
    Eigen::Index k = 0;
    for (; flown >> status >> inside; ++k) {
      for (double& value : x_hat)
        if (!(flown >> value)) throw std::runtime_error(in + ": the flight printed what is not a number");
      if (k >= run.samples()) break;
      samples += 1.0;
      in_domain += inside;
      ok += status == 0 ? 1.0 : 0.0;
      if (k == 0) {
        runs += 1.0;
        first_in_domain += inside;
        const bool in_range = ((x_hat - lowest).array() >= 0.0).all() && ((highest - x_hat).array() >= 0.0).all();
        first_in_range += in_range ? 1.0 : 0.0;
      }
      const bool counts = run.weight(k) > 0.0;
      scored += counts ? 1.0 : 0.0;
      for (Eigen::Index s = 0; s < nx; ++s) {
        const double wrap = model.states[static_cast<std::size_t>(s)].wrap;
        apart(s) = std::max(apart(s), std::abs(error_of(reference(s, k), x_hat(s), wrap)));
        if (!counts) continue;
        squares(s) += std::pow(error_of(run.states(s, k), x_hat(s), wrap), 2);
        power(s) += run.states(s, k) * run.states(s, k);
      }
    }
    if (k != run.samples())
      throw std::runtime_error(fmt::format("{}: {} of {} samples were flown", in, k, run.samples()));
  }
  std::map<std::string, double> figures{{"in_domain", in_domain / samples},
                                        {"first_in_domain", first_in_domain / runs},
                                        {"first_in_range", first_in_range / runs},
                                        {"ok", ok / samples}};
  for (Eigen::Index s = 0; s < nx; ++s) {
    const std::string& name = model.states[static_cast<std::size_t>(s)].name;
    figures["rmse " + name] = std::sqrt(squares(s) / scored);
    figures["parity " + name] = apart(s) / std::sqrt(power(s) / scored);
  }
  return figures;
}

}  // namespace nlo::claims
