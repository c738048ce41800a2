// SPDX-License-Identifier: MIT
// nlo dossier: the folder that an assessor asks for, made from a model by the commands that its index names.
#include <fmt/core.h>
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "codegen/base/directory.h"
#include "codegen/base/file.h"
#include "codegen/export/prepared_export.h"
#include "codegen/model_file/model_file.h"
#include "trainer/base/printable.h"
#include "trainer/commands/command.h"
#include "trainer/commands/options.h"
#include "trainer/commands/training_data.h"
#include "trainer/data/log_files.h"
#include "trainer/dossier/make_dossier.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/training/provenance.h"

namespace nlo::trainer {
namespace {

namespace fs = std::filesystem;

struct DossierArguments {
  std::string model, scalar = "float", output;
  std::vector<std::string> data;
  bool quiet = false;
};

/// Throws codegen::Error where `path` holds what is no dossier, be it made by nlo.
void check_place(const std::string& path) {
  codegen::check_directory(path);
  if (fs::is_directory(path) && !fs::is_empty(path) && !fs::exists(path + "/SHA256SUMS"))
    throw codegen::Error(fmt::format("{}: is another folder that nlo has made; choose another one with -o", path));
}

/// Of the runs that the experiment's plant makes, as training hashes them. Further rounds of [feedback] hang on the
/// observers of the rounds before, which nobody has kept.
std::string simulated_hash(const Experiment& experiment) {
  const RunData data = simulated_data(experiment);
  return hex_text(training_data_hash(data.training, data.validation));
}

void run_dossier(const DossierArguments& arguments) {
  codegen::scalar_type(arguments.scalar);  // throws Error for one that there is not
  check_place(arguments.output);
  DossierInput input;
  input.program = fs::read_symlink("/proc/self/exe").string();
  input.model_text = codegen::read_file(arguments.model);
  input.model = codegen::parse_model(input.model_text, arguments.model);
  input.scalar = arguments.scalar;
  std::optional<Experiment> experiment;
  for (const auto& entry : input.model.provenance)
    if (entry.first == "config") experiment = experiment_of(input.model, arguments.model);
  if (experiment) input.experiment = &*experiment;
  if (!arguments.data.empty())
    for (const std::string& log : expand_files("", arguments.data))
      input.logs.push_back(fs::absolute(log).lexically_normal().string());

  const DossierTable& table = dossier_table();
  const auto say = [&](const std::string& text) {
    if (!arguments.quiet) fmt::print(stderr, "{}\n", printable(text));
  };
  const auto files = run_phase([&] {
    if (experiment && experiment->plant && !(experiment->feedback && experiment->feedback->rounds > 0)) {
      say("simulating the training data");
      input.data_hash = simulated_hash(*experiment);
    }
    Dossier dossier = make_dossier(input, table, say);
    for (const DossierEntry& entry : dossier.entries)
      if (!entry.refusal.empty()) say(fmt::format("not made: {}: {}", entry.item->file, entry.refusal));
    std::vector<codegen::NamedText> all = with_pages(input, table, std::move(dossier));
    check_place(arguments.output);
    codegen::write_directory_atomically(arguments.output, all);
    return all;
  });
  if (!arguments.quiet) fmt::print("dossier  {}/index.md, {} files\n", arguments.output, files.size());
}

}  // namespace

void add_dossier(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<DossierArguments>();
  CLI::App* command =
      app.add_subcommand("dossier", "Collect what an assessor asks for: results, bounds, export, hashes");
  Options options(*command);
  options.value("MODEL", arguments->model, "model.json of nlo train")->required();
  options.value("--data", arguments->data, "CSV logs (or globs) that no training has seen, to evaluate on");
  options.shown("--scalar", arguments->scalar, "arithmetic of the export: float, double, or int16 (kkl)");
  options.flag("-q,--quiet", arguments->quiet, "print nothing when it succeeds");
  options.directory("-o,--output", arguments->output, "folder to write: new, empty, or an unchanged dossier")
      ->required();
  command->footer(
      "Each file is what one command prints or writes; index.md names it. Needs a C and a C++ compiler: the export is\n"
      "flown first. Two runs give the same bytes.\n"
      "Examples:\n"
      "  nlo dossier runs/van_der_pol/model.json -o dossier\n"
      "  nlo dossier runs/qube/model.json --data 'logs/test_*.csv' -o dossier");
  command->callback([arguments, &action] { action = [arguments] { run_dossier(*arguments); }; });
}

}  // namespace nlo::trainer
