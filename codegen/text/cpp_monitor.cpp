// SPDX-License-Identifier: MIT
#include "codegen/text/cpp_monitor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "codegen/base/number.h"

namespace nlo::codegen {

std::vector<MonitorConstant> monitor_constants(const Model& model, const Initialiser& init) {
  const Monitor& m = *model.monitor;
  const auto per = [](const Eigen::VectorXd& v) { return Eigen::VectorXd(v.cwiseInverse()); };
  const Eigen::MatrixXd prediction = per(m.deviation).asDiagonal() * m.prediction;
  const Eigen::VectorXd gain = -(-model.sample_period_s / m.windows_s.array()).expm1().matrix();
  const char *outputs = "[kNy]", *latents = "[kNz]", *windows = "[kWindows]", *both = "[kNy][kWindows]";
  std::vector<MonitorConstant> constants = {
      {"prediction", "Scalar", "[kNy][kWatchFeatures]", init.rows(prediction, 6, "monitor.prediction")},
      {"offset", "Scalar", outputs, init.vector(m.offset.cwiseQuotient(m.deviation), "monitor.offset")},
      {"per_deviation", "Scalar", outputs, init.vector(per(m.deviation), "monitor.deviation")},
      {"least_variance", "Scalar", outputs, init.vector(m.least_variance, "monitor.least_variance")},
      {"latent_mean", "Scalar", latents, init.vector(m.latent_mean, "monitor.latent_mean")},
      {"per_latent_deviation", "Scalar", latents, init.vector(per(m.latent_deviation), "monitor.latent_deviation")},
      {"gain", "Scalar", windows, init.vector(gain, "monitor.windows_s")},
      {"mean_limit", "Scalar", both, init.matrix(m.mean_limit, "monitor.mean_limit")},
      {"variance_limit", "Scalar", both, init.matrix(m.variance_limit, "monitor.variance_limit")},
      {"correlation_limit", "Scalar", both, init.matrix(m.correlation_limit, "monitor.correlation_limit")},
      {"latent_limit", "Scalar", windows, init.vector(m.latent_limit, "monitor.latent_limit")},
      {"missing_limit", "Scalar", outputs, init.vector(m.missing_limit, "monitor.missing_limit")},
      {"gate_squared", "Scalar", "", init(m.gate * m.gate, "monitor.gate")},
      {"armed_after", "int32_t", "", std::to_string(armed_after(m, model.sample_period_s))},
  };
  if (m.freezes_none()) return constants;
  const auto counts = [](const Eigen::VectorXd& v) { return fmt::format("{{{}}}", fmt::join(v.cast<int>(), ", ")); };
  constants.push_back({"most_equal", "uint16_t", outputs, counts(m.most_equal)});
  constants.push_back({"resting", "Scalar", outputs, init.vector(m.resting, "monitor.resting")});
  constants.push_back({"witness", "uint8_t", outputs, counts(m.witness)});
  constants.push_back({"rest_min", "Scalar", outputs, init.vector(m.rest_min, "monitor.rest_min")});
  constants.push_back({"rest_max", "Scalar", outputs, init.vector(m.rest_max, "monitor.rest_max")});
  return constants;
}

std::string monitor_promise(const Monitor& m) {
  return fmt::format(
      "// Says when the observer is wrong: limits for {} false alarms an hour, set on {} h of runs like the "
      "training's.\n",
      literal(m.false_alarms_per_hour), literal(m.hours));
}

std::string cpp_monitor(const Model& model, const Initialiser& init) {
  const Monitor& m = *model.monitor;
  std::string text =
      "\n" + monitor_promise(m) +
      fmt::format(
          "using MonitorModel = nlo::MonitorModel<{}, {}, {}, {}, {}, {}>;  // n_x, n_y, n_z, n_r, windows\n"
          "using Monitor = nlo::Monitor<MonitorModel>;\n"
          "inline constexpr MonitorModel kMonitor = {{\n",
          init.scalar_name(), model.nx(), model.ny(), model.nz(), model.nr(), m.windows());
  for (const MonitorConstant& constant : monitor_constants(model, init))
    text += fmt::format("    .{} = {},\n", constant.name, constant.value);
  return text + "};\n";
}

}  // namespace nlo::codegen
