// SPDX-License-Identifier: MIT
#include "codegen/targets/replay.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <vector>

#include "codegen/replay_run.h"
#include "codegen/targets/generated_text.h"

namespace nlo::codegen {
namespace {

// How much further than its emulation (codegen/replay_run.h) an export may be from the equations: it sums in another
// order, and discretises irregular steps in its own scalar.
constexpr double kTimesMeasured = 8.0;
constexpr double kTimesMeasuredInt16 = 1.25;  // of the estimate: its integers have the bits of the emulation
constexpr double kTimesRounding = 8.0;        // of the largest value: an emulation may happen to be exact

/// How far each row of an export may be off.
Eigen::VectorXd tolerance(const Eigen::MatrixXd& want, const Eigen::MatrixXd& got, double times, ScalarType scalar) {
  const double rounding =
      kTimesRounding * (scalar == ScalarType::kDouble ? std::numeric_limits<double>::epsilon()
                                                      : static_cast<double>(std::numeric_limits<float>::epsilon()));
  // Rounding relative to the largest entry of any row: pairs mix theirs.
  const Eigen::VectorXd measured = times * (want - got).cwiseAbs().rowwise().maxCoeff();
  return measured.array() + rounding * want.cwiseAbs().maxCoeff();
}

std::string signal(const Initialiser& init, const Eigen::VectorXd& y) {
  std::string text = "{";
  for (Eigen::Index j = 0; j < y.size(); ++j) {
    if (j > 0) text += ", ";
    text += std::isfinite(y(j)) ? init(y(j), "sample") : "kMissed";
  }
  return text + "}";
}

std::string samples_text(const Initialiser& init, const ReplayRun& run) {
  const ReplayInputs& inputs = run.inputs;
  std::string text;
  for (Eigen::Index k = 0; k < inputs.dt_s.size(); ++k)
    text += fmt::format("    {{{}, {}, {}StepStatus::{}, {}, {}}},\n", init(inputs.dt_s(k), "dt_s"),
                        signal(init, inputs.outputs.col(k)),
                        inputs.inputs.rows() == 0 ? "" : signal(init, inputs.inputs.col(k)) + ", ",
                        run.status[static_cast<std::size_t>(k)], init.vector(run.z.col(k), "z"),
                        init.vector(run.x_hat.col(k), "x_hat"));
  return text;
}

constexpr const char* kNearest = "// Outside of the domain, T* is that of the nearest point in it: what int16 does.\n";

constexpr const char* kTop =
    R"(// {0}: what its observer must answer, generated. Do not edit; make it again by
//   nlo export model.json --target replay{1} -o {0}_replay.h
//
// The answers are the model's equations in double, nothing folded. Tolerances: {2:g} times the largest difference
// that the exported arithmetic (folded, in {3}, with the runtime's activation) showed on these very samples, plus {4:g}
// rounding units of the largest value: sums in another order round otherwise, a wrong weight is much further off.
{12}//
//   #include "{0}.h"
//   #include "{0}_replay.h"
//   nlo::{0}::Observer observer{{nlo::{0}::kModel}};
//   const int wrong = nlo::{0}::replay::first_mismatch(observer);  // -1: all as they must be
#pragma once

#include <nlo/vector.h>

#include <limits>

namespace nlo::{0}::replay {{

struct Sample {{
  {11} dt_s;  // 0: one sample period
  {11} y[{5}];
{10}  StepStatus status;
  {11} z[{6}];
  {11} x_hat[{7}];
}};

inline constexpr {11} kMissed = std::numeric_limits<{11}>::quiet_NaN();
inline constexpr {11} kLatentTolerance[{6}] = {8};
inline constexpr {11} kEstimateTolerance[{7}] = {9};

inline constexpr Sample kSamples[] = {{
)";

constexpr const char* kBottom = R"(}};

/// Steps `observer`, fresh or reset, through the samples. Returns the first that it answers wrongly, or -1.
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
    if (!good) return index;
    ++index;
  }}
  return -1;
}}

}}  // namespace nlo::{4}::replay
)";

}  // namespace

std::string replay(const Model& m, const ExportOptions& options) {
  const ReplayRun run = run_replay(m, options);
  const std::string name = export_name(m, options);
  const Initialiser init(options.scalar);
  const bool is_int16 = options.scalar == ScalarType::kInt16;
  const double times = is_int16 ? kTimesMeasuredInt16 : kTimesMeasured;
  const auto within = [&](const Eigen::MatrixXd& want, const Eigen::MatrixXd& got, double factor) {
    return init.vector(tolerance(want, got, factor, options.scalar), "tolerance");
  };

  std::string flags;
  if (options.scalar != ScalarType::kFloat) flags += fmt::format(" --scalar {}", scalar_name(options.scalar));
  if (name != m.name) flags += " --name " + name;
  const bool driven = m.nu() > 0;
  const std::string input_field = driven ? fmt::format("  {} u[{}];\n", init.scalar_name(), m.nu()) : "";
  const std::string input_copy =
      driven
          ? fmt::format("    typename Observer::Input u{{}};\n    for (int i = 0; i < {}; ++i) u[i] = sample.u[i];\n",
                        m.nu())
          : "";
  return fmt::format(kTop, name, flags, times, scalar_name(options.scalar), kTimesRounding, m.ny(), m.nz(), m.nx(),
                     within(run.z, run.exported_z, kTimesMeasured), within(run.x_hat, run.exported_x_hat, times),
                     input_field, init.scalar_name(), is_int16 ? kNearest : "") +
         samples_text(init, run) +
         fmt::format(kBottom, init.scalar_name(), m.ny(), m.nz(), m.nx(), name, input_copy, driven ? "u, " : "",
                     driven ? ", u" : "");
}

}  // namespace nlo::codegen
