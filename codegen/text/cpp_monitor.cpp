// SPDX-License-Identifier: MIT
#include "codegen/text/cpp_monitor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace nlo::codegen {
namespace {

std::string initialised(const MonitorConstant& c, const Initialiser& init) {
  const std::string_view extents = c.extents;
  if (extents.empty()) return c.is_integer() ? fmt::format("{:.0f}", c.values(0, 0)) : init(c.values(0, 0), c.field);
  if (c.is_integer()) return fmt::format("{{{:.0f}}}", fmt::join(c.values.reshaped(), ", "));
  if (c.name == std::string_view("prediction") || c.name == std::string_view("row"))
    return init.rows(c.values, 6, c.field);
  return extents.find("][") == std::string_view::npos ? init.vector(c.values, c.field) : init.matrix(c.values, c.field);
}

}  // namespace

std::vector<MonitorConstant> monitor_constants(const Model& model, const Initialiser& init) {
  const Monitor& m = *model.monitor;
  const auto per = [](const Eigen::VectorXd& v) { return Eigen::VectorXd(v.cwiseInverse()); };
  const Eigen::MatrixXd prediction = per(m.deviation).asDiagonal() * m.prediction;
  const Eigen::VectorXd gain = -(-model.sample_period_s / m.windows_s.array()).expm1().matrix();
  const char *outputs = "[kNy]", *latents = "[kNz]", *windows = "[kWindows]", *both = "[kNy][kWindows]";
  const Eigen::MatrixXd gate = Eigen::MatrixXd::Constant(1, 1, m.gate * m.gate),
                        armed = Eigen::MatrixXd::Constant(1, 1, armed_after(m, model.sample_period_s));
  std::vector<MonitorConstant> constants = {
      {"prediction", "Scalar", "[kNy][kWatchFeatures]", "prediction", prediction, {}},
      {"offset", "Scalar", outputs, "offset", m.offset.cwiseQuotient(m.deviation), {}},
      {"per_deviation", "Scalar", outputs, "deviation", per(m.deviation), {}},
      {"least_variance", "Scalar", outputs, "least_variance", m.least_variance, {}},
      {"latent_mean", "Scalar", latents, "latent_mean", m.latent_mean, {}},
      {"per_latent_deviation", "Scalar", latents, "latent_deviation", per(m.latent_deviation), {}},
      {"gain", "Scalar", windows, "windows_s", gain, {}},
      {"mean_limit", "Scalar", both, "mean_limit", m.mean_limit, {}},
      {"variance_limit", "Scalar", both, "variance_limit", m.variance_limit, {}},
      {"correlation_limit", "Scalar", both, "correlation_limit", m.correlation_limit, {}},
      {"latent_limit", "Scalar", windows, "latent_limit", m.latent_limit, {}},
      {"missing_limit", "Scalar", outputs, "missing_limit", m.missing_limit, {}},
      {"gate_squared", "Scalar", "", "gate", gate, {}},
      {"armed_after", "int32_t", "", "armed_after_s", armed, {}},
  };
  if (!m.freezes_none()) {
    constants.push_back({"most_equal", "uint16_t", outputs, "most_equal", m.most_equal, {}});
    constants.push_back({"resting", "Scalar", outputs, "resting", m.resting, {}});
    constants.push_back({"reference_sensor", "uint8_t", outputs, "reference_sensor", m.reference_sensor, {}});
    constants.push_back({"rest_min", "Scalar", outputs, "rest_min", m.rest_min, {}});
    constants.push_back({"rest_max", "Scalar", outputs, "rest_max", m.rest_max, {}});
    constants.push_back({"most_moved", "Scalar", outputs, "most_moved", m.most_moved, {}});
  }
  if (m.scales_with_motion()) constants.push_back({"motion", "Scalar", outputs, "motion", m.motion, {}});
  if (m.compares_row()) {
    const Eigen::VectorXd per_row = m.row_deviation.unaryExpr([](double d) { return d == 0.0 ? 0.0 : 1.0 / d; });
    const char* states = "[kNx]";
    constants.push_back({"row", "Scalar", "[kNx][kWatchRowFeatures]", "row", per_row.asDiagonal() * m.row, {}});
    constants.push_back({"row_offset", "Scalar", states, "row_offset", m.row_offset.cwiseProduct(per_row), {}});
    constants.push_back({"per_row_deviation", "Scalar", states, "row_deviation", per_row, {}});
    constants.push_back({"disagreement_limit", "Scalar", states, "disagreement_limit", m.disagreement_limit, {}});
  }
  if (m.replaces_any()) constants.push_back({"replaces", "uint8_t", outputs, "replaces", m.replaces, {}});
  for (MonitorConstant& constant : constants) {
    constant.field.insert(0, "monitor.");
    constant.text = initialised(constant, init);
  }
  return constants;
}

std::string monitor_promise(const Monitor& m) {
  return wrapped_comment(
      fmt::format("// Detects that the observer is wrong. Its limits are set for {} an hour, on {} h of runs as in "
                  "training.\n",
                  counted(rounded_text(m.false_alarms_per_hour), "false alarm"), rounded_text(m.hours)));
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
    text += fmt::format("    .{} = {},\n", constant.name, constant.text);
  return text + "};\n";
}

}  // namespace nlo::codegen
