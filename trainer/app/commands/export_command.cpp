// SPDX-License-Identifier: MIT
// nlo export: model file -> files of a target.
#include <fmt/core.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/base/identifier.h"
#include "codegen/model_file/model_file.h"
#include "codegen/targets/cpp_cost.h"
#include "codegen/targets/error_limits.h"
#include "codegen/targets/prepared_export.h"
#include "codegen/targets/target_registry.h"
#include "codegen/targets/write_export.h"
#include "trainer/app/commands/command.h"
#include "trainer/app/commands/input_facts.h"
#include "trainer/app/commands/options.h"
#include "trainer/app/commands/output_directory.h"
#include "trainer/app/replay/checked_flight.h"
#include "trainer/base/printable.h"

namespace nlo::trainer {
namespace {

struct ExportArguments {
  std::string model, target = "cpp", scalar = "float", weights = "float", name, output, max_error, roles;
  int samples = codegen::ExportOptions{}.samples;
  double clock_mhz = 168.0;
  bool check = false, quiet = false;
};

/// The text for the user about an export, and the reason for a refusal (empty: none).
struct Judged {
  std::string tables, refusal;
};

/// How long a step takes on a Cortex-M4. Empty for numbers that cortex_m4_time() is not for.
std::string time_line(const codegen::PreparedExport& prepared, const ExportArguments& arguments) {
  if (prepared.options().scalar != codegen::ScalarType::kFloat) return "";
  const codegen::CppCost cost = cpp_cost(prepared);
  const auto [least, most] = codegen::cortex_m4_time(cost, arguments.clock_mhz);
  return fmt::format(
      "a step with its estimate on a Cortex-M4 with an FPU at {:g} MHz: {:.3g} to {:.3g} us\n"
      "  2.2 M / f to (4.3 M + 30 A + 3000) / f with M = {} multiply-adds, A = {} activations; --target "
      "selftest "
      "counts\n",
      arguments.clock_mhz, least, most, cost.multiply_adds(), cost.activations());
}

/// Throws Error if --max-error cannot be read.
Judged judge(const codegen::PreparedExport& prepared, const ExportArguments& arguments) {
  std::optional<Eigen::VectorXd> limits;
  if (!arguments.max_error.empty()) limits = codegen::error_limits(arguments.max_error, prepared.model());
  Judged judged{codegen::error_table(prepared) + time_line(prepared, arguments), {}};
  if (limits) judged.refusal = codegen::beyond_limits(prepared, *limits);
  return judged;
}

/// Parts of the model that the target has no form for: a firmware that counts on them would not build, or fly without.
std::string left_out_warnings(const codegen::PreparedExport& prepared, const ExportArguments& arguments) {
  std::string warnings;
  if (prepared.model().error && (!prepared.folded().error || codegen::export_target(arguments.target).of_c99))
    warnings += fmt::format(
        "warning: the standard deviations of its errors are left out: estimate_with_error() is of C++ in float and "
        "double, and this is {}\n",
        prepared.folded().error ? "--target " + arguments.target : "--scalar int16");
  return warnings;
}

void run_export(const ExportArguments& arguments) {
  const codegen::ExportTarget& target = codegen::export_target(arguments.target);
  codegen::ExportOptions options;
  options.scalar = codegen::scalar_type(arguments.scalar);
  options.weights = codegen::weight_type(arguments.weights);
  options.name = arguments.name;
  options.samples = arguments.samples;
  if (!options.name.empty() && !codegen::is_identifier(options.name))
    throw codegen::Error(
        fmt::format("--name \"{}\" is not an identifier; use a letter, then letters, digits and single "
                    "underscores (63 at most), no C++ word",
                    options.name));
  options.roles = arguments.roles;
  if (!options.roles.empty() && !target.roles)
    throw codegen::Error(
        fmt::format("--roles: target {} asks for none; leave it out, or export simplefoc", target.name));
  const bool to_stdout = arguments.output == "-";
  if (to_stdout && target.form != codegen::ExportForm::kFile)
    throw codegen::Error(
        fmt::format("-o -: target {} writes several files, and stdout is one; name where they go", target.name));
  if (!to_stdout && target.form != codegen::ExportForm::kDirectory) check_output_file(arguments.output, true);
  const codegen::Model model = codegen::read_model(arguments.model);
  const bool has_tiers = !target.of_c99;  // accuracies of tanh; C99 has only the best
  const codegen::PreparedExport prepared(model, options, has_tiers ? arguments.max_error : "");
  const std::vector<codegen::NamedText> files = target.generate(prepared);
  if (!to_stdout) codegen::check_export(target, files, arguments.output);
  if (arguments.check && target.no_observer)
    throw codegen::Error(
        fmt::format("--check flies an export, and target {} has no observer; leave it out", target.name));
  const std::string seen = arguments.check ? check_flight(prepared, files) : "";
  const Judged judged = judge(prepared, arguments);
  if (!arguments.quiet) fmt::print(stderr, "{}", printable(ignored_inputs_note(model)));
  if (model.monitor && !model.monitor->lowered.empty())
    fmt::print(stderr,
               "note: {}: monitor.{} had limits that could never be reached; lower ones are exported. Make the monitor "
               "again: nlo monitor\n",
               printable(arguments.model), fmt::join(model.monitor->lowered, ", monitor."));
  fmt::print(stderr, "{}", left_out_warnings(prepared, arguments));
  if (!judged.refusal.empty()) {
    fmt::print(stderr, "{}", printable(judged.tables));
    throw RunFailure(judged.refusal);
  }
  if (to_stdout) {
    if (!arguments.quiet) fmt::print(stderr, "{}{}", printable(judged.tables), seen);
    fmt::print("{}", files.front().text);
    return;
  }
  std::vector<std::string> written;
  run_phase([&] {
    make_folder_of(arguments.output);
    written = codegen::write_export(target, files, arguments.output);
  });
  if (arguments.quiet) return;
  fmt::print("{}{}", printable(judged.tables), seen);
  for (std::size_t i = 0; i < written.size(); ++i) fmt::print("{}: {} bytes\n", written[i], files[i].text.size());
}

}  // namespace

void add_export(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<ExportArguments>();
  CLI::App* command = app.add_subcommand("export", "Turn a model into a header of constants for firmware");
  Options options(*command);
  options.value("MODEL", arguments->model, "model.json of nlo train")->required();
  std::string targets;
  for (const codegen::ExportTarget& target : codegen::export_targets())
    targets += fmt::format("{}{}: {}", targets.empty() ? "" : "; ", target.name, target.description);
  options.shown("--target", arguments->target, targets);
  options.shown("--scalar", arguments->scalar, "arithmetic on the target: float, double, or int16 (kkl)");
  options.shown("--weights", arguments->weights,
                "stored weights: float, or half the bytes in bf16 or fp16 (cpp, replay); arithmetic stays in float");
  options.value("--name", arguments->name,
                "namespace of the generated code, an identifier (default: the model's name)");
  options.value("--max-error", arguments->max_error,
                "refuse when a state's largest error in the model's domain is beyond VALUE, or STATE=VALUE,...; in "
                "float, take the cheapest tanh that keeps within it",
                "VALUE");
  options.value("--roles", arguments->roles,
                "simplefoc: which output is the shaft's angle (none: no output is) and which state its velocity, where "
                "units do not tell",
                "angle=NAME,velocity=NAME");
  options.number("--samples", arguments->samples, 20, 100000,
                 "how many a replay or a self-test has: fewer for a small flash");
  options.number("--clock", arguments->clock_mhz, 1.0, 10000.0,
                 "the clock of a Cortex-M4 [MHz], for the time of a step");
  options.flag(
      "--check", arguments->check,
      "compile it with $CC and $CXX (or cc, c++) and replay generated readings first: refuse unless it answers "
      "as the model does, and C99 and C++ to the bit alike");
  options.flag("-q,--quiet", arguments->quiet, "print nothing when the export succeeds, except what it leaves out");
  options
      .value("-o,--output", arguments->output,
             "file or folder to write, in a folder that is made where there is none; - for stdout")
      ->required();
  command->footer(
      "Examples:\n"
      "  nlo export runs/van_der_pol/model.json -o firmware/van_der_pol.h\n"
      "  nlo export model.json --scalar int16 --max-error x1=0.01,x2=0.02 -o van_der_pol.h\n"
      "  nlo export model.json --weights bf16 --max-error 0.02 -o van_der_pol.h\n"
      "  nlo export model.json --target replay -o van_der_pol_replay.h\n"
      "  nlo export model.json --target c99 -o van_der_pol.h                      (and van_der_pol.c)\n"
      "  nlo export model.json --target selftest -o selftest                      (a program for your board)\n"
      "  nlo export model.json --target arduino -o ~/Arduino/libraries/van_der_pol\n"
      "  nlo export model.json --target simplefoc --roles angle=theta,velocity=omega -o ~/Arduino/libraries/motor\n"
      "  nlo export model.json --target fmu -o van_der_pol.fmu                    (with a binary by $CC, or cc)\n"
      "A folder is replaced only while all of it is as nlo has written it.");
  command->callback([arguments, &action] { action = [arguments] { run_export(*arguments); }; });
}

}  // namespace nlo::trainer
