// SPDX-License-Identifier: MIT
// nlo certify: what can be proven of a model, rounding included, and what a search finds beside each bound.
#include <fmt/core.h>
#include <fmt/format.h>

#include <memory>
#include <string>

#include "codegen/model_file/model_file.h"
#include "trainer/base/printable.h"
#include "trainer/certificates/certificate.h"
#include "trainer/commands/command.h"
#include "trainer/commands/options.h"

namespace nlo::trainer {
namespace {

struct CertifyArguments {
  std::string model;
  CertifyOptions options;
  bool json = false, quiet = false;
};

void run_certify(CertifyArguments arguments) {
  const codegen::Model model = codegen::read_model(arguments.model);
  if (!arguments.quiet)
    arguments.options.progress = [](const std::string& rows) { fmt::print(stderr, "{} ...\n", rows); };
  run_phase([&] {
    const Certificate certificate = certify(model, arguments.options);
    fmt::print("{}", arguments.json ? certificate_json(certificate) : printable(certificate_text(certificate)));
    if (const std::string broken = broken_rows(certificate); !broken.empty())
      throw RunFailure(fmt::format("a search is above a proven bound: {}: a defect of this program", broken));
  });
}

}  // namespace

void add_certify(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<CertifyArguments>();
  CLI::App* command =
      app.add_subcommand("certify", "Prove bounds of a model, rounding included, and search for what breaks them");
  Options options(*command);
  options.value("MODEL", arguments->model, "model.json of nlo train")->required();
  options
      .value("--boxes", arguments->options.boxes,
             "most boxes of each branch and bound (default: as many as take some minute)")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1000000000}));
  options.number("--gap", arguments->options.gap, 0.001, 100.0,
                 "a branch and bound ends once its bound is above what is found by less than this share");
  options.seed(arguments->options.seed, "seed of the searches");
  options.flag("--json", arguments->json, "one JSON object instead of the table");
  options.flag("-q,--quiet", arguments->quiet, "no progress on stderr");
  command->footer(
      "Each row says what it rests on: proven, sampled or assumed. A search runs beside each bound.\n"
      "Examples:\n"
      "  nlo certify runs/van_der_pol/model.json\n"
      "  nlo certify runs/van_der_pol/model.json --boxes 1000000 --gap 0.05 --json");
  command->callback([arguments, &action] { action = [arguments] { run_certify(*arguments); }; });
}

}  // namespace nlo::trainer
