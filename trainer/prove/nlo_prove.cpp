// SPDX-License-Identifier: MIT
// The program `nlo-prove`, which `nlo certify` starts: it proves bounds of a model, including rounding, and searches
// for errors above each bound.
#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>

#include "codegen/base/error.h"
#include "codegen/model_file/model_file.h"
#include "trainer/app/commands/command.h"
#include "trainer/app/commands/options.h"
#include "trainer/app/commands/program.h"
#include "trainer/base/number_text.h"
#include "trainer/base/printable.h"
#include "trainer/base/version.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/prove/bounded_errors.h"
#include "trainer/prove/certificate.h"

namespace nlo::trainer {
namespace {

struct CertifyArguments {
  std::string model;
  std::string noise, disturbance = "0", box;
  CertifyOptions options;
  bool json = false, quiet = false;
};

/// Parses "x1=-1:1,x2=-2:2", the range of every state.
StateBox parse_box(const std::string& text, const codegen::Model& model) {
  if (text.empty()) return {};
  const auto refuse = [&](const std::string& why) {
    return codegen::Error(
        fmt::format("--box {}: {}; write each state's range, such as {}=-1:1", text, why, model.states.front().name));
  };
  StateBox box{Eigen::VectorXd::Zero(model.nx()), Eigen::VectorXd::Zero(model.nx())};
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find(',', start), text.size());
    const std::string part = text.substr(start, end - start);
    const std::size_t equals = part.find('='), colon = part.find(':', equals);
    if (equals == std::string::npos || colon == std::string::npos)
      throw refuse(fmt::format("\"{}\" is not a range", part));
    const auto state = std::ranges::find(model.states, part.substr(0, equals), &codegen::Channel::name);
    if (state == model.states.end()) throw refuse(fmt::format("the model has no state \"{}\"", part.substr(0, equals)));
    const auto low = finite_number(part.substr(equals + 1, colon - equals - 1)),
               high = finite_number(part.substr(colon + 1));
    if (!low || !high || *low >= *high)
      throw refuse(fmt::format("\"{}\" does not go from a smaller to a larger number", part));
    const auto i = state - model.states.begin();
    if (box.radius(i) > 0.0) throw refuse(state->name + " is given twice");
    box.centre(i) = 0.5 * (*low + *high);
    box.radius(i) = 0.5 * (*high - *low);
    start = end + 1;
  }
  for (Eigen::Index i = 0; i < model.nx(); ++i)
    if (box.radius(i) == 0.0)
      throw refuse(fmt::format("{} has no range", model.states[static_cast<std::size_t>(i)].name));
  return box;
}

/// Returns the experiment of the model, if its file has one that the program can read.
std::optional<Experiment> known_experiment(const codegen::Model& model, const std::string& path) try {
  return experiment_of(model, path);
} catch (const codegen::Error&) {
  return std::nullopt;
}

void run_certify(CertifyArguments arguments) {
  const codegen::Model model = codegen::read_model(arguments.model);
  const std::optional<Experiment> experiment = known_experiment(model, arguments.model);
  if (experiment) arguments.options.experiment = &*experiment;
  arguments.options.noise = noise_limit(arguments.noise, experiment ? experiment->training.noise : NoiseConfig{});
  arguments.options.disturbance = disturbance_limit(arguments.disturbance);
  arguments.options.box = parse_box(arguments.box, model);
  if (!arguments.quiet)
    arguments.options.progress = [](const std::string& rows) { fmt::print(stderr, "{} ...\n", rows); };
  run_phase([&] {
    const Certificate certificate = certify(model, arguments.options);
    fmt::print("{}", arguments.json ? certificate_json(certificate) : printable(certificate_text(certificate)));
    if (const std::string broken = broken_rows(certificate); !broken.empty())
      throw RunFailure(fmt::format(
          "a search exceeded a proven bound: {}; this is a defect of nlo, please report it with the model", broken));
  });
}

void add_options(CLI::App& app, CertifyArguments& arguments) {
  Options options(app);
  options.value("MODEL", arguments.model, "model.json of nlo train")->required();
  options
      .value("--boxes", arguments.options.boxes,
             "largest number of boxes that each branch and bound examines (default: as many as take about a minute)")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1000000000}));
  options.number("--gap", arguments.options.gap, 0.001, 100.0,
                 "relative gap: each branch and bound stops once (bound - largest value found) / largest value found "
                 "is below this");
  options.value("--noise", arguments.noise,
                "noise of the outputs for the steady error: uniform:HALF_WIDTH or none (default: uniform, with the "
                "standard deviation of the training noise)");
  options.shown("--disturbance", arguments.disturbance,
                "disturbance for the steady error: largest |w| on a state's derivative", "W");
  options.value("--box", arguments.box,
                "range of the states for the steady error: x1=LOW:HIGH,x2=LOW:HIGH (default: range of simulated runs)");
  options.seed(arguments.options.seed, "seed of the searches");
  options.flag("--json", arguments.json, "one JSON object instead of the table");
  options.flag("-q,--quiet", arguments.quiet, "no progress on stderr");
  app.footer(
      "Each row names its evidence: proven, or sampled (the largest value at finitely many points). For each bound, a "
      "search looks for larger values.\n"
      "Examples:\n"
      "  nlo certify runs/van_der_pol/model.json --noise uniform:0.1\n"
      "  nlo certify runs/van_der_pol/model.json --boxes 1000000 --gap 0.05 --json");
  app.set_version_flag("-V,--version", std::string("nlo-prove ") + kVersion);
}

}  // namespace
}  // namespace nlo::trainer

int main(int argc, char** argv) {
  using namespace nlo::trainer;  // NOLINT(google-build-using-namespace): a program
  return run_program(argc, argv, "nlo certify", kCertifyDescription, [](CLI::App& app, Action& action) {
    auto arguments = std::make_shared<CertifyArguments>();
    add_options(app, *arguments);
    action = [arguments] { run_certify(*arguments); };
  });
}
