// SPDX-License-Identifier: MIT
#include "codegen/model_file/monitor_fields.h"

#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include <nlo/monitor_model.h>

#include "codegen/model/field_checks.h"
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
/// Fields of a monitor that detects frozen sensors.
constexpr std::array<std::pair<const char*, Eigen::VectorXd Monitor::*>, 6> kFrozen = {{
    {"most_equal", &Monitor::most_equal},
    {"resting", &Monitor::resting},
    {"reference_sensor", &Monitor::reference_sensor},
    {"rest_min", &Monitor::rest_min},
    {"rest_max", &Monitor::rest_max},
    {"most_moved", &Monitor::most_moved},
}};
/// Fields of a monitor that compares states with their linear fit.
constexpr std::array<std::pair<const char*, Eigen::VectorXd Monitor::*>, 3> kRow = {{
    {"row_offset", &Monitor::row_offset},
    {"row_deviation", &Monitor::row_deviation},
    {"disagreement_limit", &Monitor::disagreement_limit},
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

/// Requires that divisors lie within [least, most]. Then every level is finite in float32, and every limit can be
/// exceeded.
void check_within(const Eigen::MatrixXd& values, double least, double most, const std::string& field) {
  for (Eigen::Index i = 0; i < values.rows(); ++i)
    for (Eigen::Index j = 0; j < values.cols(); ++j)
      if (!(values(i, j) >= least && values(i, j) <= most))
        fail("{}[{}]{} is {}; it must be from {:g} to {:g}", field, i, values.cols() == 1 ? "" : fmt::format("[{}]", j),
             values(i, j), least, most);
}

constexpr double kMostSquare = kLargestInnovation * kLargestInnovation;

/// The largest value that a statistic keeps during a fault. A constant innovation c makes p and v approach c^2, so
/// their ratio approaches 1.
struct Reach {
  const char* limit;
  double most;
};
constexpr std::array<Reach, 5> kReaches = {{{"mean_limit", 1.0},
                                            {"variance_limit", kMostSquare},
                                            {"correlation_limit", kMostSquare},
                                            {"latent_limit", kMostSquare},
                                            {"missing_limit", 1.0}}};

template <class Limits>
bool lower(Limits& limits, double reach) {
  constexpr double kBelow = 0.9;
  bool any = false;
  for (double& limit : limits.reshaped())
    if (limit >= reach && limit != kNoLimit) any = (limit = kBelow * reach, true);
  return any;
}

/// If a statistic cannot reach its limit, the alarm can never be raised. This is an error, unless the limit is
/// kNoLimit.
void check_limit(const Eigen::MatrixXd& limits, double least, double reach, const std::string& field) {
  check_within(limits, least, kNoLimit, field);
  for (const double limit : limits.reshaped())
    if (limit != kNoLimit && limit >= reach)
      fail(
          "{} has {}, but the statistic is at most {:g}, so this alarm could never be raised. Make the monitor again "
          "(nlo monitor), or write {:g} for a statistic that is not watched",
          field, limit, reach, kNoLimit);
}

}  // namespace

std::string monitor_json(const Monitor& monitor, const std::string& indent) {
  JsonObject object(indent);
  for (const auto& [name, member] : kNumbers) object.field(name, literal(monitor.*member));
  for (const auto& [name, member] : kVectors) object.vector(name, monitor.*member);
  for (const auto& [name, member] : kMatrices) object.matrix(name, monitor.*member);
  if (!monitor.freezes_none())
    for (const auto& [name, member] : kFrozen) object.vector(name, monitor.*member);
  if (monitor.scales_with_motion()) object.vector("motion", monitor.motion);
  if (monitor.compares_row()) {
    object.matrix("row", monitor.row);
    for (const auto& [name, member] : kRow) object.vector(name, monitor.*member);
  }
  if (monitor.replaces_any()) object.vector("replaces", monitor.replaces);
  return object.text();
}

Monitor monitor(const Field& field, Eigen::Index states) {
  std::vector<const char*> keys;
  for (const auto& row : kNumbers) keys.push_back(row.first);
  for (const auto& row : kVectors) keys.push_back(row.first);
  for (const auto& row : kMatrices) keys.push_back(row.first);
  for (const auto& row : kFrozen) keys.push_back(row.first);
  for (const auto& row : kRow) keys.push_back(row.first);
  keys.insert(keys.end(), {"motion", "row", "replaces"});
  field.allow_only(keys);
  Monitor read;
  for (const auto& [name, member] : kNumbers) read.*member = number(field[name]);
  for (const auto& [name, member] : kVectors) read.*member = vector(field[name]);
  for (const auto& [name, member] : kMatrices) read.*member = matrix(field[name]);
  leave_out_frozen(read, read.deviation.size());
  leave_out_motion_and_row(read, read.deviation.size(), states,
                           read.prediction.cols() > states ? read.prediction.cols() - states : 0);
  for (const auto& [name, member] : kFrozen)
    if (field.has(name)) read.*member = vector(field[name]);
  if (field.has("motion")) read.motion = vector(field["motion"]);
  if (field.has("row")) {
    read.row = matrix(field["row"]);
    for (const auto& [name, member] : kRow) read.*member = vector(field[name]);
  }
  if (field.has("replaces")) read.replaces = vector(field["replaces"]);
  for (const Reach& reach : kReaches) {
    bool lowered = false;
    for (const auto& [name, member] : kMatrices)
      if (name == std::string_view(reach.limit)) lowered = lower(read.*member, reach.most);
    for (const auto& [name, member] : kVectors)
      if (name == std::string_view(reach.limit)) lowered = lower(read.*member, reach.most);
    if (lowered) read.lowered.emplace_back(reach.limit);
  }
  return read;
}

void check_monitor(const Model& model) {
  if (!model.monitor) return;
  const Monitor& m = *model.monitor;
  constexpr int kMostWindows = 8;
  constexpr double kLongest = 1e6;                    // samples
  constexpr double kLeast = 1e-12, kMost = kNoLimit;  // limits of divisors
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
  const std::array<Eigen::MatrixXd, 5> limited = {m.mean_limit, m.variance_limit, m.correlation_limit, m.latent_limit,
                                                  m.missing_limit};
  for (std::size_t i = 0; i < kReaches.size(); ++i)
    check_limit(limited[i], kLeast, kReaches[i].most, fmt::format("monitor.{}", kReaches[i].limit));
  for (const auto& [name, member] : kFrozen) check_shape(m.*member, model.ny(), fmt::format("monitor.{}", name), "n_y");
  constexpr double kMostEqual = 65534;  // equal readings are counted in 16 bits; the largest count means frozen
  check_within(m.most_equal, 0.0, kMostEqual, "monitor.most_equal");
  check_within(m.reference_sensor, 0.0, model.measured() - 1, "monitor.reference_sensor");
  for (const auto& [name, counts] : {std::pair{"most_equal", &m.most_equal}, {"reference_sensor", &m.reference_sensor}})
    if (*counts != counts->array().floor().matrix()) fail("monitor.{} has a number that is not an integer", name);
  for (const Eigen::VectorXd* reading : {&m.resting, &m.rest_min, &m.rest_max})
    check_within(*reading, -kLargestNumber, kLargestNumber, "monitor.resting, rest_min or rest_max");
  check_within(m.most_moved, 0.0, kLargestNumber, "monitor.most_moved");
  check_shape(m.motion, model.ny(), "monitor.motion", "n_y");
  check_within(m.motion, 0.0, kMostSquare, "monitor.motion");
  check_shape(m.row, model.nx(), model.nz() + model.nr(), "monitor.row", "n_x x (n_z + n_r)");
  for (const auto& [name, member] : kRow) check_shape(m.*member, model.nx(), fmt::format("monitor.{}", name), "n_x");
  for (Eigen::Index i = 0; i < model.nx(); ++i) {
    if (m.row_deviation(i) == 0.0 && m.disagreement_limit(i) == 0.0) continue;
    check_within(m.row_deviation.segment(i, 1), kSmallestNumber, kLargestNumber, "monitor.row_deviation");
    check_limit(m.disagreement_limit.segment(i, 1), kLeast, kMostSquare, "monitor.disagreement_limit");
  }
  if (m.replaces.size() > 0) {
    check_shape(m.replaces, model.ny(), "monitor.replaces", "n_y");
    for (Eigen::Index j = 0; j < model.ny(); ++j)
      if (m.replaces(j) != 0.0 && m.replaces(j) != 1.0)
        fail("monitor.replaces[{}] is {}; it must be 0 or 1", j, m.replaces(j));
  }
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
