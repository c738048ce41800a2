// SPDX-License-Identifier: MIT
#include "codegen/text/cpp_monitor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "codegen/base/number.h"

namespace nlo::codegen {

std::string cpp_monitor(const Model& model, const Initialiser& init) {
  const Monitor& m = *model.monitor;
  const auto per = [](const Eigen::VectorXd& v) { return Eigen::VectorXd(v.cwiseInverse()); };
  const Eigen::MatrixXd prediction = per(m.deviation).asDiagonal() * m.prediction;
  const Eigen::VectorXd gain = -(-model.sample_period_s / m.windows_s.array()).expm1().matrix();
  std::string text = fmt::format(
      "\n// Says when the observer is wrong: limits for {} false alarms an hour, set on {} h of runs like the "
      "training's.\n"
      "using MonitorModel = nlo::MonitorModel<{}, {}, {}, {}, {}, {}>;  // n_x, n_y, n_z, n_r, windows\n"
      "using Monitor = nlo::Monitor<MonitorModel>;\n"
      "inline constexpr MonitorModel kMonitor = {{\n",
      literal(m.false_alarms_per_hour), literal(m.hours), init.scalar_name(), model.nx(), model.ny(), model.nz(),
      model.nr(), m.windows());
  const auto field = [&](const char* name, const std::string& value) {
    text += fmt::format("    .{} = {},\n", name, value);
  };
  field("prediction", init.rows(prediction, 6, "monitor.prediction"));
  field("offset", init.vector(m.offset.cwiseQuotient(m.deviation), "monitor.offset"));
  field("per_deviation", init.vector(per(m.deviation), "monitor.deviation"));
  field("least_variance", init.vector(m.least_variance, "monitor.least_variance"));
  field("latent_mean", init.vector(m.latent_mean, "monitor.latent_mean"));
  field("per_latent_deviation", init.vector(per(m.latent_deviation), "monitor.latent_deviation"));
  field("gain", init.vector(gain, "monitor.windows_s"));
  field("mean_limit", init.matrix(m.mean_limit, "monitor.mean_limit"));
  field("variance_limit", init.matrix(m.variance_limit, "monitor.variance_limit"));
  field("correlation_limit", init.matrix(m.correlation_limit, "monitor.correlation_limit"));
  field("latent_limit", init.vector(m.latent_limit, "monitor.latent_limit"));
  field("missing_limit", init.vector(m.missing_limit, "monitor.missing_limit"));
  field("gate_squared", init(m.gate * m.gate, "monitor.gate"));
  field("armed_after", std::to_string(armed_after(m, model.sample_period_s)));
  if (m.freezes_none()) return text + "};\n";
  const auto counts = [](const Eigen::VectorXd& v) { return fmt::format("{{{}}}", fmt::join(v.cast<int>(), ", ")); };
  field("most_equal", counts(m.most_equal));
  field("resting", init.vector(m.resting, "monitor.resting"));
  field("witness", counts(m.witness));
  field("rest_min", init.vector(m.rest_min, "monitor.rest_min"));
  field("rest_max", init.vector(m.rest_max, "monitor.rest_max"));
  return text + "};\n";
}

}  // namespace nlo::codegen
