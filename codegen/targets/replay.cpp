// SPDX-License-Identifier: MIT
#include "codegen/targets/replay.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <vector>

#include "codegen/error.h"
#include "codegen/fold.h"
#include "codegen/reference_observer.h"
#include "codegen/targets/generated_text.h"
#include "codegen/targets/replay_inputs.h"

namespace nlo::codegen {
namespace {

// How much further than the emulation below an export may be from the equations: it sums in another order, and
// discretises irregular steps in its own scalar.
constexpr double kTimesMeasured = 8.0;
constexpr double kTimesRounding =
    8.0;  // of the largest value, so that an emulation that happens to be exact allows some

/// What the observer must answer to each sample, and how exactly.
struct Answers {
  Eigen::MatrixXd z, x_hat;  ///< n_z x N, n_x x N
  std::vector<std::string> status;
  Eigen::VectorXd z_tolerance, x_hat_tolerance;
};

Network as_network(const FoldedNetwork& folded, int inputs) {
  const Eigen::Index reads = folded.inputs(), out = folded.layers.back().bias.size();
  return {.features = Eigen::MatrixXd::Identity(reads, inputs),
          .feature_mean = Eigen::VectorXd::Zero(reads),
          .feature_scale = Eigen::VectorXd::Ones(reads),
          .activation = folded.activation,
          .layers = folded.layers,
          .skip = folded.linear_path,
          .output_mean = Eigen::VectorXd::Zero(out),
          .output_scale = Eigen::VectorXd::Ones(out)};
}

/// The model with its networks folded, as it is exported.
Model as_exported(Model m, const FoldedModel& folded) {
  const auto rewrite = [](Network& network, const FoldedNetwork& by) {
    if (!by.empty()) network = as_network(by, network.inputs());
  };
  rewrite(m.inverse_map, folded.inverse_map);
  if (m.drive) rewrite(m.drive->forward_map, folded.forward_map);
  if (m.luenberger) rewrite(m.luenberger->nonlinearity, folded.nonlinearity);
  if (m.dynamics) rewrite(*m.dynamics, folded.dynamics);
  return m;
}

/// The runtime's rules for bad measurements, in terms of what was measured.
class Screen {
 public:
  Screen(const Model& model, int stale_after) : model_(model), stale_after_(stale_after) {}

  const char* status(const Eigen::VectorXd& y, const Eigen::VectorXd& u) {
    bool held = !u.allFinite(), clamped = false;
    for (int j = 0; j < model_.ny(); ++j) {
      const bool outside = y(j) < model_.output_min(j) || y(j) > model_.output_max(j);
      const bool angle = model_.outputs[static_cast<std::size_t>(j)].wrap > 0.0;
      held = held || !std::isfinite(y(j)) || (angle && outside);
      clamped = clamped || outside;
    }
    held_ = held ? held_ + 1 : 0;
    return held_ >= stale_after_ ? "kStale" : held ? "kHeld" : clamped ? "kClamped" : "kOk";
  }

 private:
  const Model& model_;
  int stale_after_, held_ = 0;
};

/// Runs the equations in double for the answers, and the exported arithmetic in Scalar for the tolerances.
template <class Scalar>
Answers answers_to(const ReplayInputs& inputs, const Model& m, const FoldedModel& folded) {
  ReferenceObserver<double> exact(m);
  ReferenceObserver<Scalar> rounded(as_exported(m, folded), Activations::kRuntime);
  Screen screen(m, folded.stale_after);
  const Eigen::Index samples = inputs.dt_s.size();
  Answers a{Eigen::MatrixXd(m.nz(), samples), Eigen::MatrixXd(m.nx(), samples), {}, {}, {}};
  Eigen::MatrixXd z_rounded = a.z, x_hat_rounded = a.x_hat;
  for (Eigen::Index k = 0; k < samples; ++k) {
    const Eigen::VectorXd y = inputs.outputs.col(k), u = inputs.inputs.col(k);
    const double dt_s = inputs.dt_s(k) == 0.0 ? m.sample_period_s : inputs.dt_s(k);
    exact.step(y, u, dt_s);
    rounded.step(y, u, dt_s);
    Eigen::VectorXd turned = Eigen::VectorXd::Zero(m.ny());  // whole turns, which the exported observer takes back
    for (int j = 0; j < m.ny(); ++j) {
      const double wrap = m.outputs[static_cast<std::size_t>(j)].wrap;
      if (wrap > 0.0) turned(j) = wrap * std::round(exact.output()(j) / wrap);
    }
    const Eigen::VectorXd back =
        has_linear_latent(m) ? Eigen::VectorXd(folded.steady_gain * turned) : Eigen::VectorXd::Zero(m.nz());
    a.z.col(k) = exact.latent() - back;
    a.x_hat.col(k) = exact.estimate();
    a.status.emplace_back(screen.status(y, u));
    z_rounded.col(k) = rounded.latent().template cast<double>() - back;
    x_hat_rounded.col(k) = rounded.estimates(z_rounded.col(k), exact.output() - turned);
  }
  constexpr double kRounding = kTimesRounding * static_cast<double>(std::numeric_limits<Scalar>::epsilon());
  // Rounding relative to the largest entry of any row: pairs mix theirs.
  const auto tolerance = [&](const Eigen::MatrixXd& want, const Eigen::MatrixXd& got) -> Eigen::VectorXd {
    const Eigen::VectorXd measured = kTimesMeasured * (want - got).cwiseAbs().rowwise().maxCoeff();
    return measured.array() + kRounding * want.cwiseAbs().maxCoeff();
  };
  a.z_tolerance = tolerance(a.z, z_rounded);
  a.x_hat_tolerance = tolerance(a.x_hat, x_hat_rounded);
  return a;
}

std::string signal(const Initialiser& init, const Eigen::VectorXd& y) {
  std::string text = "{";
  for (Eigen::Index j = 0; j < y.size(); ++j) {
    if (j > 0) text += ", ";
    text += std::isfinite(y(j)) ? init(y(j), "sample") : "kMissed";
  }
  return text + "}";
}

std::string samples_text(const Initialiser& init, const ReplayInputs& inputs, const Answers& a) {
  std::string text;
  for (Eigen::Index k = 0; k < inputs.dt_s.size(); ++k)
    text += fmt::format(
        "    {{{}, {}, {}StepStatus::{}, {}, {}}},\n", init(inputs.dt_s(k), "dt_s"),
        signal(init, inputs.outputs.col(k)), inputs.inputs.rows() == 0 ? "" : signal(init, inputs.inputs.col(k)) + ", ",
        a.status[static_cast<std::size_t>(k)], init.vector(a.z.col(k), "z"), init.vector(a.x_hat.col(k), "x_hat"));
  return text;
}

constexpr const char* kTop =
    R"(// {0}: what its observer must answer, generated. Do not edit; make it again by
//   nlo export model.json --target replay{1} -o {0}_replay.h
//
// The answers are the model's equations in double, nothing folded. Tolerances: {2:g} times the largest difference
// that the exported arithmetic (folded, in {3}, with the runtime's activation) showed on these very samples, plus {4:g}
// rounding units of the largest value: sums in another order round otherwise, a wrong weight is much further off.
//
//   #include "{0}.h"
//   #include "{0}_replay.h"
//   nlo::{0}::Observer observer{{nlo::{0}::kModel}};
//   const int wrong = nlo::{0}::replay::first_mismatch(observer);  // -1: all as they must be
#pragma once

#include <nlo/vector.h>

#include <limits>

namespace nlo::{0}::replay {{

struct Sample {{
  {3} dt_s;  // 0: one sample period
  {3} y[{5}];
{10}  StepStatus status;
  {3} z[{6}];
  {3} x_hat[{7}];
}};

inline constexpr {3} kMissed = std::numeric_limits<{3}>::quiet_NaN();
inline constexpr {3} kLatentTolerance[{6}] = {8};
inline constexpr {3} kEstimateTolerance[{7}] = {9};

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
  constexpr int kFewest = 20, kMost = 1000000;
  if (options.samples < kFewest || options.samples > kMost)
    throw Error(fmt::format("{} replay samples asked for; {} to {} make sense", options.samples, kFewest, kMost));
  validate(m);
  const std::string name = export_name(m, options);
  const Initialiser init(options.scalar);
  const bool single = options.scalar == ScalarType::kFloat;
  const FoldedModel folded = fold(m);

  ReplayInputs inputs = replay_inputs(m, folded.stale_after, options.seed, options.samples);
  if (single) {  // both sides see the very same measurements
    inputs.dt_s = inputs.dt_s.cast<float>().cast<double>().eval();
    inputs.outputs = inputs.outputs.cast<float>().cast<double>().eval();
    inputs.inputs = inputs.inputs.cast<float>().cast<double>().eval();
  }
  const Answers a = single ? answers_to<float>(inputs, m, folded) : answers_to<double>(inputs, m, folded);

  std::string flags;
  if (!single) flags += " --scalar double";
  if (name != m.name) flags += " --name " + name;
  const bool driven = m.nu() > 0;
  const std::string input_field = driven ? fmt::format("  {} u[{}];\n", init.scalar_name(), m.nu()) : "";
  const std::string input_copy =
      driven
          ? fmt::format("    typename Observer::Input u{{}};\n    for (int i = 0; i < {}; ++i) u[i] = sample.u[i];\n",
                        m.nu())
          : "";
  return fmt::format(kTop, name, flags, kTimesMeasured, init.scalar_name(), kTimesRounding, m.ny(), m.nz(), m.nx(),
                     init.vector(a.z_tolerance, "tolerance"), init.vector(a.x_hat_tolerance, "tolerance"),
                     input_field) +
         samples_text(init, inputs, a) +
         fmt::format(kBottom, init.scalar_name(), m.ny(), m.nz(), m.nx(), name, input_copy, driven ? "u, " : "",
                     driven ? ", u" : "");
}

}  // namespace nlo::codegen
