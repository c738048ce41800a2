// SPDX-License-Identifier: MIT
#include "codegen/targets/golden_replay.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <string>

#include "codegen/base/embedded_text.h"
#include "codegen/replay/replay_run.h"
#include "codegen/targets/c99.h"
#include "codegen/targets/number_formats.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {
namespace {

// The tolerance of an export is this many times the error of its emulation (codegen/replay/replay_run.h), because the
// export sums in another order and discretises irregular steps in its own scalar.
constexpr double kTimesMeasured = 8.0;
constexpr double kTimesMeasuredInt16 = 1.25;  // factor for the estimate, whose integers equal those of the emulation
// Factor for 16-bit weights and a coarser tanh, whose error equals that of the emulation except for rounding.
constexpr double kTimesCoarse = 1.25;
// Number of rounding units of the largest value, because the emulation may have no error.
constexpr double kTimesRounding = 8.0;

/// Returns the tolerance of each row of an export.
Eigen::VectorXd tolerance(const Eigen::MatrixXd& want, const Eigen::MatrixXd& got, double times, ScalarType scalar) {
  const double rounding =
      kTimesRounding * (scalar == ScalarType::kDouble ? std::numeric_limits<double>::epsilon()
                                                      : static_cast<double>(std::numeric_limits<float>::epsilon()));
  // Rounding is relative to the largest entry of any row, because the two rows of a pair mix.
  const Eigen::VectorXd measured = times * (want - got).cwiseAbs().rowwise().maxCoeff();
  // An unknown sigma is the same number in every arithmetic.
  const auto size = want.array().abs();
  return measured.array() + rounding * (size < static_cast<double>(kUnknownSigma)).select(size, 0.0).maxCoeff();
}

/// Returns the tolerance of `coarse`, an export with 16-bit weights or a coarser tanh. `plain` is the same without
/// them.
Eigen::VectorXd tolerance(const ReplayRun& coarse, const ReplayRun& plain, Eigen::MatrixXd ReplayRun::*want,
                          Eigen::MatrixXd ReplayRun::*got) {
  return kTimesCoarse * (coarse.*want - coarse.*got).cwiseAbs().rowwise().maxCoeff() +
         tolerance(plain.*want, plain.*got, kTimesMeasured, ScalarType::kFloat);
}

/// Content of a replay in any language.
struct Golden {
  std::string name, flags;  ///< flags: options of the export that it belongs to
  Initialiser init;
  ReplayRun run;
  std::string z_tolerance, x_hat_tolerance, sigma_tolerance, explanation;
};

const char* status_name(StepStatus status) {
  switch (status) {
    case StepStatus::kOk:
      return "kOk";
    case StepStatus::kClamped:
      return "kClamped";
    case StepStatus::kHeld:
      return "kHeld";
    case StepStatus::kStale:
      return "kStale";
    case StepStatus::kOutOfRange:
      return "kOutOfRange";
    case StepStatus::kRejected:
      return "kRejected";
    case StepStatus::kDiverged:
      return "kDiverged";
    case StepStatus::kReset:
      return "kReset";
  }
  return "";
}

std::string signal(const Initialiser& init, const Eigen::VectorXd& y, const std::string& missed) {
  std::string text = "{";
  for (Eigen::Index j = 0; j < y.size(); ++j) {
    if (j > 0) text += ", ";
    text += std::isfinite(y(j)) ? init(y(j), "sample") : missed;
  }
  return text + "}";
}

/// Writes one line per sample. `missed` is a NaN in the file's language, and `status_text` writes a status in it. A
/// line ends in the standard deviations `sigma`, n_x x N, if there are any.
template <class StatusText>
std::string samples_text(const Golden& golden, int measured, const std::string& missed, const StatusText& status_text,
                         const Eigen::MatrixXd& sigma) {
  const Initialiser& init = golden.init;
  const ReplayRun& run = golden.run;
  const ReplayInputs& inputs = run.inputs;
  std::string text;
  for (Eigen::Index k = 0; k < inputs.dt_s.size(); ++k)
    text += fmt::format("    {{{}, {}, {}{}, {}, {}{}}},\n", init(inputs.dt_s(k), "dt_s"),
                        signal(init, inputs.outputs.col(k).head(measured), missed),
                        inputs.inputs.rows() == 0 ? "" : signal(init, inputs.inputs.col(k), missed) + ", ",
                        status_text(status_name(run.status[static_cast<std::size_t>(k)])),
                        init.vector(run.z.col(k), "z"), init.vector(run.x_hat.col(k), "x_hat"),
                        sigma.size() == 0 ? "" : ", " + init.vector(sigma.col(k), "sigma"));
  return text;
}

constexpr const char* kNearest = "// Outside of the domain, int16 returns T* of the nearest point of the domain.\n";

constexpr const char* kBesidePlain =
    "// Added to it are {:g} times the differences of plain float with the most accurate tanh.\n";

constexpr const char* kExplanation =
    R"(// The expected results are those of the model's equations in double, with nothing folded. A tolerance is
// {0:g} times the largest difference of the exported arithmetic (folded, in {1}, with the runtime's activation) on
// these samples, plus {2:g} rounding units of the largest value. Sums in another order stay within it; a wrong weight
// does not.
{3})";

constexpr const char* kTop =
    R"(// {0}: golden inputs and the expected results of its observer, generated. Do not edit. To make it again:
//   nlo export model.json --target replay{1} -o {0}_replay.h
//
{2}//
//   #include "{0}.h"
//   #include "{0}_replay.h"
//   nlo::{0}::Observer observer{{nlo::{0}::kModel}};
//   const int wrong = nlo::{0}::replay::first_mismatch(observer);  // -1: all results are right
#pragma once

#include <nlo/vector.h>

#include <limits>

namespace nlo::{0}::replay {{

struct Sample {{
  {3} dt_s;  // 0: one sample period
  {3} y[{4}];
{5}  StepStatus status;
  {3} z[{6}];
  {3} x_hat[{7}];
{10}}};

inline constexpr {3} kMissed = std::numeric_limits<{3}>::quiet_NaN();
inline constexpr {3} kLatentTolerance[{6}] = {8};
inline constexpr {3} kEstimateTolerance[{7}] = {9};
{11}
inline constexpr Sample kSamples[] = {{
)";

constexpr const char* kBottom = R"(}};

/// Steps `observer`, new or reset, through the samples. Returns the index of the first wrong result, or -1.
template <class Observer>
int first_mismatch(Observer& observer) {{
  const auto agrees = []({0} got, {0} want, {0} tolerance) {{
    return got - want <= tolerance && want - got <= tolerance;  // false for NaN
  }};
  int index = 0;
  for (const Sample& sample : kSamples) {{
    typename Observer::Output y{{}};
    for (int j = 0; j < {1}; ++j) y[j] = sample.y[j];
{5}    const StepStatus status = sample.dt_s > {0}(0) ? observer.step(y, {6}sample.dt_s) : observer.step(y{7});
    const auto z = observer.latent();
    const auto x_hat = observer.estimate();
    bool good = status == sample.status;
    for (int r = 0; r < {2}; ++r) good = good && agrees(z[r], sample.z[r], kLatentTolerance[r]);
    for (int i = 0; i < {3}; ++i) good = good && agrees(x_hat[i], sample.x_hat[i], kEstimateTolerance[i]);
{8}    if (!good) return index;
    ++index;
  }}
  return -1;
}}

}}  // namespace nlo::{4}::replay
)";

/// Returns the factor on the errors of the emulation.
double times_measured(const ExportOptions& options) {
  const bool is_coarse = options.weights != WeightType::kFull || options.tanh != Activation::kTanh;
  return options.scalar == ScalarType::kInt16 ? kTimesMeasuredInt16 : is_coarse ? kTimesCoarse : kTimesMeasured;
}

Golden golden(const PreparedExport& prepared) {
  const ExportOptions& options = prepared.options();
  const Initialiser& init = prepared.initialiser();
  GoldenReplay replay = golden_replay(prepared);
  Golden result{prepared.name(), number_flags(options), init, std::move(replay.run), "", "", "", ""};
  if (result.name != prepared.model().name) result.flags += " --name " + result.name;
  result.z_tolerance = init.vector(replay.z_tolerance, "tolerance");
  result.x_hat_tolerance = init.vector(replay.x_hat_tolerance, "tolerance");
  if (replay.sigma_tolerance.size() != 0) result.sigma_tolerance = init.vector(replay.sigma_tolerance, "tolerance");
  const bool is_int16 = options.scalar == ScalarType::kInt16;
  const bool is_coarse = options.weights != WeightType::kFull || options.tanh != Activation::kTanh;
  result.explanation = fmt::format(kExplanation, times_measured(options), numbers_name(options), kTimesRounding,
                                   is_int16    ? kNearest
                                   : is_coarse ? fmt::format(kBesidePlain, kTimesMeasured)
                                               : "");
  return result;
}

}  // namespace

GoldenReplay golden_replay(const PreparedExport& prepared) {
  const ExportOptions& options = prepared.options();
  GoldenReplay result{run_replay(prepared), {}, {}, {}};
  const ReplayRun& run = result.run;
  const bool has_sigma = run.sigma.size() != 0;
  if (options.weights != WeightType::kFull || options.tanh != Activation::kTanh) {
    ExportOptions same = best_tanh(options);
    same.weights = WeightType::kFull;
    const ReplayRun plain = run_replay(prepared.with(same));
    result.z_tolerance = tolerance(run, plain, &ReplayRun::z, &ReplayRun::exported_z);
    result.x_hat_tolerance = tolerance(run, plain, &ReplayRun::x_hat, &ReplayRun::exported_x_hat);
    if (has_sigma) result.sigma_tolerance = tolerance(run, plain, &ReplayRun::sigma, &ReplayRun::exported_sigma);
    return result;
  }
  const auto within = [&](const Eigen::MatrixXd& want, const Eigen::MatrixXd& got, double factor) {
    return tolerance(want, got, factor, options.scalar);
  };
  result.z_tolerance = within(run.z, run.exported_z, kTimesMeasured);
  result.x_hat_tolerance = within(run.x_hat, run.exported_x_hat, times_measured(options));
  if (has_sigma) result.sigma_tolerance = within(run.sigma, run.exported_sigma, kTimesMeasured);
  return result;
}

std::string replay(const PreparedExport& prepared) {
  const Model& m = prepared.model();
  const Golden g = golden(prepared);
  const std::string scalar = g.init.scalar_name();
  const bool driven = m.nu() > 0;
  const std::string input_field = driven ? fmt::format("  {} u[{}];\n", scalar, m.nu()) : "";
  const std::string input_copy =
      driven
          ? fmt::format("    typename Observer::Input u{{}};\n    for (int i = 0; i < {}; ++i) u[i] = sample.u[i];\n",
                        m.nu())
          : "";
  std::string sigma_field, sigma_tolerance, sigma_check;
  if (g.run.sigma.size() != 0) {
    sigma_field = fmt::format("  {} sigma[{}];\n", scalar, m.nx());
    sigma_tolerance =
        fmt::format("inline constexpr {} kDeviationTolerance[{}] = {};\n", scalar, m.nx(), g.sigma_tolerance);
    sigma_check = fmt::format(
        "    const auto sigma = observer.estimate_with_error().sigma;\n"
        "    for (int i = 0; i < {}; ++i) good = good && agrees(sigma[i], sample.sigma[i], kDeviationTolerance[i]);\n",
        m.nx());
  }
  return fmt::format(kTop, g.name, g.flags, g.explanation, scalar, m.measured(), input_field, m.nz(), m.nx(),
                     g.z_tolerance, g.x_hat_tolerance, sigma_field, sigma_tolerance) +
         samples_text(
             g, m.measured(), "kMissed", [](const std::string& status) { return "StepStatus::" + status; },
             g.run.sigma) +
         fmt::format(kBottom, scalar, m.measured(), m.nz(), m.nx(), g.name, input_copy, driven ? "u, " : "",
                     driven ? ", u" : "", sigma_check);
}

std::string replay_c99(const PreparedExport& prepared) {
  const Model& m = prepared.model();
  check_c99(m);
  check_weights(prepared.options(), "replay-c99");
  const Golden g = golden(prepared.with(best_tanh(prepared.options())));
  const auto status_text = [&g](std::string status) {  // kOk: NAME_OK
    std::string words;                                 // kOutOfRange: OUT_OF_RANGE
    for (const char c : status.substr(1)) {
      const bool small = c >= 'a' && c <= 'z';
      if (!small && !words.empty()) words += '_';
      words += static_cast<char>(small ? c - 'a' + 'A' : c);
    }
    return g.name + "_" + words;
  };
  return filled(embedded_text("c99/replay.h.in"),
                {{"NAME", g.name},
                 {"FLAGS", g.flags},
                 {"EXPLANATION", g.explanation},
                 {"SCALAR", g.init.scalar_name()},
                 {"F", g.init.scalar_bytes() == 4 ? "f" : ""},
                 {"NX", std::to_string(m.nx())},
                 {"NM", std::to_string(m.measured())},
                 {"U_FIELD", m.nu() > 0 ? fmt::format("  {} u[{}];\n", g.init.scalar_name(), m.nu()) : ""},
                 {"U_ARGUMENT", m.nu() > 0 ? ", sample->u" : ""},
                 {"NZ", std::to_string(m.nz())},
                 {"Z_TOLERANCE", g.z_tolerance},
                 {"X_TOLERANCE", g.x_hat_tolerance},
                 {"SAMPLES", std::to_string(g.run.inputs.dt_s.size())},
                 {"ANSWERS", samples_text(g, m.measured(), g.name + "_MISSED", status_text, {})}});
}

}  // namespace nlo::codegen
