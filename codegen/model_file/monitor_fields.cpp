// SPDX-License-Identifier: MIT
#include "codegen/model_file/monitor_fields.h"

#include <array>
#include <cmath>
#include <utility>

#include "codegen/model/checks.h"
#include "codegen/model/json_object.h"

namespace nlo::codegen {
namespace {

constexpr std::array<std::pair<const char*, Eigen::MatrixXd Monitor::*>, 4> kMatrices = {{
    {"prediction", &Monitor::prediction},
    {"mean_limit", &Monitor::mean_limit},
    {"variance_limit", &Monitor::variance_limit},
    {"correlation_limit", &Monitor::correlation_limit},
}};
constexpr std::array<std::pair<const char*, Eigen::VectorXd Monitor::*>, 8> kVectors = {{
    {"offset", &Monitor::offset},
    {"deviation", &Monitor::deviation},
    {"least_variance", &Monitor::least_variance},
    {"latent_mean", &Monitor::latent_mean},
    {"latent_deviation", &Monitor::latent_deviation},
    {"windows_s", &Monitor::windows_s},
    {"latent_limit", &Monitor::latent_limit},
    {"missing_limit", &Monitor::missing_limit},
}};
/// Only where a sensor may be frozen.
constexpr std::array<std::pair<const char*, Eigen::VectorXd Monitor::*>, 5> kFrozen = {{
    {"most_equal", &Monitor::most_equal},
    {"resting", &Monitor::resting},
    {"witness", &Monitor::witness},
    {"rest_min", &Monitor::rest_min},
    {"rest_max", &Monitor::rest_max},
}};
constexpr std::array<std::pair<const char*, double Monitor::*>, 4> kNumbers = {{
    {"gate", &Monitor::gate},
    {"armed_after_s", &Monitor::armed_after_s},
    {"false_alarms_per_hour", &Monitor::false_alarms_per_hour},
    {"hours", &Monitor::hours},
}};

void check_positive_number(double value, const char* field) {
  if (!(value > 0.0) || !std::isfinite(value)) fail("monitor.{} is {}; it must be positive", field, value);
}

/// Of what is divided by: with both ends no level leaves float32, and no limit is one that nothing ever passes.
void check_within(const Eigen::MatrixXd& values, double least, double most, const std::string& field) {
  for (Eigen::Index i = 0; i < values.rows(); ++i)
    for (Eigen::Index j = 0; j < values.cols(); ++j)
      if (!(values(i, j) >= least && values(i, j) <= most))
        fail("{}[{}]{} is {}; it must be from {:g} to {:g}", field, i, values.cols() == 1 ? "" : fmt::format("[{}]", j),
             values(i, j), least, most);
}

}  // namespace

std::string monitor_json(const Monitor& monitor, const std::string& indent) {
  JsonObject object(indent);
  for (const auto& [name, member] : kNumbers) object.field(name, literal(monitor.*member));
  for (const auto& [name, member] : kVectors) object.vector(name, monitor.*member);
  for (const auto& [name, member] : kMatrices) object.matrix(name, monitor.*member);
  if (!monitor.freezes_none())
    for (const auto& [name, member] : kFrozen) object.vector(name, monitor.*member);
  return object.text();
}

Monitor monitor(const Field& field) {
  std::vector<const char*> keys;
  for (const auto& row : kNumbers) keys.push_back(row.first);
  for (const auto& row : kVectors) keys.push_back(row.first);
  for (const auto& row : kMatrices) keys.push_back(row.first);
  for (const auto& row : kFrozen) keys.push_back(row.first);
  field.allow_only(keys);
  Monitor read;
  for (const auto& [name, member] : kNumbers) read.*member = number(field[name]);
  for (const auto& [name, member] : kVectors) read.*member = vector(field[name]);
  for (const auto& [name, member] : kMatrices) read.*member = matrix(field[name]);
  for (const auto& [name, member] : kFrozen)
    read.*member = field.has(name) ? vector(field[name]) : Eigen::VectorXd::Zero(read.deviation.size());
  return read;
}

void check_monitor(const Model& model) {
  if (!model.monitor) return;
  const Monitor& m = *model.monitor;
  constexpr int kMostWindows = 8;
  constexpr double kLongest = 1e6;                // samples
  constexpr double kLeast = 1e-12, kMost = 1e12;  // statistics are 25 at most, and 25 / kLeast where they are divided
  const Eigen::Index windows = m.windows();
  if (windows < 1 || windows > kMostWindows)
    fail("monitor.windows_s has {} numbers; it must have 1 to {}", windows, kMostWindows);
  check_shape(m.prediction, model.ny(), model.nz() + model.nr() + model.nx(), "monitor.prediction",
              "n_y x (n_z + n_r + n_x)");
  check_shape(m.offset, model.ny(), "monitor.offset", "n_y");
  check_shape(m.latent_mean, model.nz(), "monitor.latent_mean", "n_z");
  const auto positive = [](const Eigen::VectorXd& v, Eigen::Index size, const std::string& field, const char* meaning) {
    check_shape(v, size, field, meaning);
    check_positive(v, field);
  };
  positive(m.deviation, model.ny(), "monitor.deviation", "n_y");
  positive(m.least_variance, model.ny(), "monitor.least_variance", "n_y");
  positive(m.latent_deviation, model.nz(), "monitor.latent_deviation", "n_z");
  positive(m.missing_limit, model.ny(), "monitor.missing_limit", "n_y");
  positive(m.windows_s, windows, "monitor.windows_s", "at least one");
  positive(m.latent_limit, windows, "monitor.latent_limit", "one for each window");
  const std::array<std::pair<const char*, const Eigen::MatrixXd*>, 3> limits = {
      {{"monitor.mean_limit", &m.mean_limit},
       {"monitor.variance_limit", &m.variance_limit},
       {"monitor.correlation_limit", &m.correlation_limit}}};
  for (const auto& [field, limit] : limits) {
    check_shape(*limit, model.ny(), windows, field, "n_y x windows");
    check_positive(limit->reshaped(), field);
  }
  check_within(m.deviation, kSmallestNumber, kLargestNumber, "monitor.deviation");
  check_within(m.latent_deviation, kSmallestNumber, kLargestNumber, "monitor.latent_deviation");
  check_within(m.least_variance, kLeast, kMost, "monitor.least_variance");
  check_within(m.latent_limit, kLeast, kMost, "monitor.latent_limit");
  check_within(m.missing_limit, kLeast, kMost, "monitor.missing_limit");
  for (const auto& [field, limit] : limits) check_within(*limit, kLeast, kMost, field);
  for (const auto& [name, member] : kFrozen) check_shape(m.*member, model.ny(), fmt::format("monitor.{}", name), "n_y");
  constexpr double kMostEqual = 65535;  // counted in 16 bits
  check_within(m.most_equal, 0.0, kMostEqual, "monitor.most_equal");
  check_within(m.witness, 0.0, model.measured() - 1, "monitor.witness");
  for (const auto& [name, counts] : {std::pair{"most_equal", &m.most_equal}, {"witness", &m.witness}})
    if (*counts != counts->array().floor().matrix()) fail("monitor.{} has a number that is not whole", name);
  for (const Eigen::VectorXd* reading : {&m.resting, &m.rest_min, &m.rest_max})
    check_within(*reading, -kLargestNumber, kLargestNumber, "monitor.resting, rest_min or rest_max");
  check_within(m.windows_s / model.sample_period_s, 1.0 / kLongest, 4.0 * kLongest,
               "monitor.windows_s / sample period");
  check_positive_number(m.gate, "gate");
  check_within(Eigen::MatrixXd::Constant(1, 1, m.gate), kLeast, kMost, "monitor.gate");
  check_positive_number(m.armed_after_s, "armed_after_s");
  check_positive_number(m.false_alarms_per_hour, "false_alarms_per_hour");
  check_positive_number(m.hours, "hours");
  if (m.armed_after_s > kLongest * model.sample_period_s)
    fail("monitor.armed_after_s is {}; it must be at most {} sample periods", m.armed_after_s, kLongest);
}

}  // namespace nlo::codegen
