// SPDX-License-Identifier: MIT
// nlo export: writes the files of a target from a model file.
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

/// The text for the user about an export, and the reason for a refusal (empty: the export is accepted).
struct Judged {
  std::string tables, refusal;
};

/// Returns a line with the time of a step on a Cortex-M4. Empty for number formats that cortex_m4_time() does not
/// cover.
std::string time_line(const codegen::PreparedExport& prepared, const ExportArguments& arguments) {
  if (prepared.options().scalar != codegen::ScalarType::kFloat) return "";
  const codegen::CppCost cost = cpp_cost(prepared);
  const auto [least, most] = codegen::cortex_m4_time(cost, arguments.clock_mhz);
  return fmt::format(
      "a step with its estimate on a Cortex-M4 with an FPU at {:g} MHz: {:.3g} to {:.3g} us\n"
      "  2.2 M / f to (4.3 M + 30 A + {}) / f with M = {} multiply-adds, A = {} activations; --target "
      "selftest "
      "counts\n",
      arguments.clock_mhz, least, most, 3000 + cost.further_instructions, cost.multiply_adds(), cost.activations());
}

/// Measures the error and checks it. Throws Error if --max-error cannot be read.
Judged judge(const codegen::PreparedExport& prepared, const ExportArguments& arguments) {
  std::optional<Eigen::VectorXd> limits;
  if (!arguments.max_error.empty()) limits = codegen::error_limits(arguments.max_error, prepared.model());
  Judged judged{codegen::error_table(prepared) + time_line(prepared, arguments), {}};
  if (limits) judged.refusal = codegen::beyond_limits(prepared, *limits);
  return judged;
}

/// Returns warnings about parts of the model that the target does not support. A firmware that needs them would not
/// compile, or would run without them.
std::string left_out_warnings(const codegen::PreparedExport& prepared, const ExportArguments& arguments) {
  std::string warnings;
  if (prepared.model().error && (!prepared.folded().error || codegen::export_target(arguments.target).of_c99))
    warnings += fmt::format(
        "warning: the standard deviations of its errors are left out: estimate_with_error() exists only in C++ in "
        "float "
        "or double, and this is {}\n",
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
        fmt::format("--name \"{}\" is not an identifier; write a letter, then letters, digits and single underscores "
                    "(at most 63 characters), but no C++ keyword",
                    options.name));
  options.roles = arguments.roles;
  if (!options.roles.empty() && !target.roles)
    throw codegen::Error(
        fmt::format("--roles: target {} has no roles; leave --roles out, or use --target simplefoc", target.name));
  const bool to_stdout = arguments.output == "-";
  if (to_stdout && target.form != codegen::ExportForm::kFile)
    throw codegen::Error(
        fmt::format("-o -: target {} writes several files, but stdout is a single file; name a file or folder with -o",
                    target.name));
  if (!to_stdout && target.form != codegen::ExportForm::kDirectory) check_output_file(arguments.output, true);
  const codegen::Model model = codegen::read_model(arguments.model);
  const bool has_tiers = !target.of_c99;  // accuracies of tanh; C99 has only the best
  const codegen::PreparedExport prepared(model, options, has_tiers ? arguments.max_error : "");
  const std::vector<codegen::NamedText> files = target.generate(prepared);
  if (!to_stdout) codegen::check_export(target, files, arguments.output);
  if (arguments.check && target.no_observer)
    throw codegen::Error(
        fmt::format("--check runs an observer, but target {} has none; leave --check out", target.name));
  const std::string seen = arguments.check ? check_flight(prepared, files) : "";
  const Judged judged = judge(prepared, arguments);
  if (!arguments.quiet) fmt::print(stderr, "{}", printable(ignored_inputs_note(model)));
  if (model.monitor && !model.monitor->lowered.empty())
    fmt::print(stderr,
               "note: {}: monitor.{} had limits that the statistic can never reach, so lower limits are exported. Run "
               "nlo monitor again to set them\n",
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
  CLI::App* command = app.add_subcommand("export", "Write a model as a header of constants for firmware");
  Options options(*command);
  options.value("MODEL", arguments->model, "model.json of nlo train")->required();
  std::string targets;
  for (const codegen::ExportTarget& target : codegen::export_targets())
    targets += fmt::format("{}{}: {}", targets.empty() ? "" : "; ", target.name, target.description);
  options.shown("--target", arguments->target, targets);
  options.shown("--scalar", arguments->scalar, "arithmetic on the target: float, double, or int16 (kkl)");
  options.shown("--weights", arguments->weights,
                "format of stored weights: float, or bf16 or fp16 with half of the bytes (cpp, replay); the arithmetic "
                "stays in float");
  options.value("--name", arguments->name,
                "namespace of the generated code, an identifier (default: the model's name)");
  options.value("--max-error", arguments->max_error,
                "largest allowed error of the arithmetic in the model's domain, VALUE or STATE=VALUE,...; an export "
                "with a larger error is refused; in float, it selects the cheapest tanh that keeps this limit",
                "VALUE");
  options.value("--roles", arguments->roles,
                "simplefoc: the output with the shaft's angle (none: there is no such output) and the state with its "
                "velocity, if the units do not show them",
                "angle=NAME,velocity=NAME");
  options.number("--samples", arguments->samples, 20, 100000,
                 "number of samples in a replay or a self-test; use fewer for a small flash");
  options.number("--clock", arguments->clock_mhz, 1.0, 10000.0, "clock of a Cortex-M4 [MHz], for the time of a step");
  options.flag("--check", arguments->check,
               "before writing, compile the export with $CC and $CXX (or cc, c++) and run it on generated readings; "
               "refuse the export unless its results agree with the model, and C99 and C++ agree bit for bit");
  options.flag("-q,--quiet", arguments->quiet,
               "print nothing if the export succeeds, except parts of the model that it leaves out");
  options.value("-o,--output", arguments->output, "file or folder to write; missing folders are made; - for stdout")
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
      "A folder is replaced only if none of its files has been changed.");
  command->callback([arguments, &action] { action = [arguments] { run_export(*arguments); }; });
}

}  // namespace nlo::trainer
