// SPDX-License-Identifier: MIT
// nlo dossier: the folder that an assessor asks for, made from a model by the commands that its index names.
#include <fmt/core.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "codegen/base/directory.h"
#include "codegen/base/file.h"
#include "codegen/base/sha256.h"
#include "codegen/export/prepared_export.h"
#include "codegen/model_file/model_file.h"
#include "trainer/base/printable.h"
#include "trainer/commands/command.h"
#include "trainer/commands/options.h"
#include "trainer/commands/training_data.h"
#include "trainer/data/log_files.h"
#include "trainer/dossier/make_dossier.h"
#include "trainer/dossier/source_hash.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/training/provenance.h"

namespace nlo::trainer {
namespace {

namespace fs = std::filesystem;

struct DossierArguments {
  std::string model, scalar = "float", output, training_data, source;
  std::vector<std::string> data;
  bool check = false, quiet = false;
};

/// Throws codegen::Error where `path` holds what is no dossier, be it made by nlo.
void check_place(const std::string& path) {
  codegen::check_directory(path);
  if (fs::is_directory(path) && !fs::is_empty(path) && !fs::exists(path + "/SHA256SUMS"))
    throw codegen::Error(fmt::format("{}: is another folder that nlo has made; choose another one with -o", path));
}

/// Of the data as training hashes them; "" where that cannot be told: of logs without their directory, and of further
/// rounds of [feedback], which hang on the observers of the rounds before, which nobody has kept.
std::string data_hash_now(const Experiment& experiment, const std::string& directory) {
  if (experiment.log ? directory.empty() : experiment.feedback && experiment.feedback->rounds > 0) return "";
  const RunData data = experiment.log ? logged_data(experiment, directory, true) : simulated_data(experiment);
  return hex_text(training_data_hash(data.training, data.validation));
}

/// Throws RunFailure where the dossier in `folder` is not `made`: which files, and of the model both hashes.
void compare(const std::string& folder, const std::vector<codegen::NamedText>& made) {
  std::vector<std::string> others;
  for (const codegen::NamedText& file : made) {
    const std::string path = folder + "/" + file.path;
    if (!fs::is_regular_file(path)) {
      others.push_back(file.path + " (is not there)");
      continue;
    }
    const std::string there = codegen::read_file(path);
    if (there == file.text) continue;
    others.push_back(file.path == "model.json" ? fmt::format("model.json (SHA-256 {} there, {} now)",
                                                             codegen::sha256(there), codegen::sha256(file.text))
                                               : file.path);
  }
  if (!others.empty())
    throw RunFailure(fmt::format("{}: is not what this model, program and machine give; differs: {}", folder,
                                 fmt::join(others, ", ")));
}

void run_dossier(const DossierArguments& arguments) {
  codegen::scalar_type(arguments.scalar);  // throws Error for one that there is not
  if (!arguments.check) check_place(arguments.output);
  if (arguments.check && !fs::is_directory(arguments.output))
    throw codegen::Error(
        fmt::format("{}: there is no dossier to check; leave --check out to make it", arguments.output));
  DossierInput input;
  input.sources = kSourceHash;
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

  if (!arguments.training_data.empty() && !(experiment && experiment->log))
    throw codegen::Error(fmt::format("--training-data: {} was not trained on logs; leave it out", arguments.model));

  if (!arguments.source.empty()) {
    if (!fs::is_regular_file(arguments.source + "/tests/proofs/export_this.sh"))
      throw codegen::Error(fmt::format("--source {}: is not a source tree of nlo with tests/proofs", arguments.source));
    input.tree = fs::canonical(arguments.source).string();
  }

  const DossierTable& table = dossier_table();
  const auto say = [&](const std::string& text) {
    if (!arguments.quiet) fmt::print(stderr, "{}\n", printable(text));
  };
  const auto files = run_phase([&] {
    if (experiment) {
      say("hashing the training data");
      input.data_hash = data_hash_now(*experiment, arguments.training_data);
    }
    Dossier dossier = make_dossier(input, table, say);
    for (const DossierEntry& entry : dossier.entries)
      if (!entry.refusal.empty()) say(fmt::format("not made: {}: {}", entry.item->file, entry.refusal));
    std::vector<codegen::NamedText> all = with_pages(input, table, std::move(dossier));
    if (arguments.check) {
      compare(arguments.output, all);
    } else {
      check_place(arguments.output);
      codegen::write_directory_atomically(arguments.output, all);
    }
    return all;
  });
  if (!arguments.quiet)
    fmt::print("dossier  {}/index.md, {} files{}\n", arguments.output, files.size(),
               arguments.check ? ", the same again" : "");
}

}  // namespace

void add_dossier(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<DossierArguments>();
  CLI::App* command =
      app.add_subcommand("dossier", "Collect what an assessor asks for: results, bounds, export, hashes");
  Options options(*command);
  options.value("MODEL", arguments->model, "model.json of nlo train")->required();
  options.value("--data", arguments->data, "CSV logs (or globs) that no training has seen, to evaluate on");
  options.directory("--training-data", arguments->training_data,
                    "directory of the logs that it was trained on: their hash is compared with the model's");
  options.shown("--scalar", arguments->scalar, "arithmetic of the export: float, double, or int16 (kkl)");
  options.directory("--source", arguments->source,
                    "nlo's source tree: its scripts for Frama-C and MISRA C run on the exported pair");
  options.flag("--check", arguments->check,
               "write nothing: make it again and compare it with the one in DIR; exit 1 names the files that differ");
  options.flag("-q,--quiet", arguments->quiet, "print nothing when it succeeds");
  options.directory("-o,--output", arguments->output, "folder to write: new, empty, or an unchanged dossier")
      ->required();
  command->footer(
      "Each file is what one command prints or writes; index.md names it. Needs a C and a C++ compiler: the export is\n"
      "flown first. Two runs give the same bytes.\n"
      "Examples:\n"
      "  nlo dossier runs/van_der_pol/model.json -o dossier\n"
      "  nlo dossier runs/qube/model.json --data 'logs/test_*.csv' --training-data logs -o dossier\n"
      "  nlo dossier dossier/model.json --check -o dossier");
  command->callback([arguments, &action] { action = [arguments] { run_dossier(*arguments); }; });
}

}  // namespace nlo::trainer
