// SPDX-License-Identifier: MIT
#include "trainer/app/report/run_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/base/number_text.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {
namespace {

using codegen::Error;

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t start = 0;;) {
    const auto end = text.find(separator, start);
    parts.push_back(text.substr(start, end - start));
    if (end == text.npos) return parts;
    start = end + 1;
  }
}

double cell(std::string_view text, const std::string& name, std::size_t line) {
  if (text.empty() || text == "nan" || text == "inf" || text == "-inf") return std::numeric_limits<double>::quiet_NaN();
  if (const auto value = finite_number(text)) return *value;
  throw Error(fmt::format("{}:{}: \"{}\" is not a number", name, line, text));
}

}  // namespace

TrainingCurves parse_training_curves(std::string_view csv, const std::string& name) {
  std::vector<std::string_view> lines = split(csv, '\n');
  for (std::string_view& line : lines)
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  while (!lines.empty() && lines.back().empty()) lines.pop_back();
  if (lines.empty()) throw Error(fmt::format("{}: is empty; expected the metrics of a training run", name));

  const std::vector<std::string_view> headings = split(lines[0], ',');
  const auto rows = static_cast<Eigen::Index>(lines.size() - 1);
  Eigen::MatrixXd values(rows, static_cast<Eigen::Index>(headings.size()));
  for (std::size_t row = 1; row < lines.size(); ++row) {
    const auto cells = split(lines[row], ',');
    if (cells.size() != headings.size())
      throw Error(
          fmt::format("{}:{}: has {} cells where the headings name {}", name, row + 1, cells.size(), headings.size()));
    for (std::size_t i = 0; i < cells.size(); ++i)
      values(static_cast<Eigen::Index>(row - 1), static_cast<Eigen::Index>(i)) = cell(cells[i], name, row + 1);
  }
  const auto has = [&](std::string_view heading) {
    return std::find(headings.begin(), headings.end(), heading) != headings.end();
  };
  const auto column = [&](std::string_view heading) -> Eigen::VectorXd {
    if (!has(heading)) return Eigen::VectorXd::Constant(rows, std::numeric_limits<double>::quiet_NaN());
    return values.col(std::find(headings.begin(), headings.end(), heading) - headings.begin());
  };
  if (!has("step"))
    throw Error(fmt::format("{}:1: has no column \"step\"; expected the metrics of a training run", name));

  TrainingCurves curves{column("step"),
                        column("elapsed_s"),
                        column("loss"),
                        column("train_rmse"),
                        column("validation_rmse"),
                        column("learning_rate"),
                        {}};
  for (int i = 1; has(fmt::format("lambda_{}_re", i)); ++i) {
    Eigen::VectorXcd curve(rows);
    curve.real() = column(fmt::format("lambda_{}_re", i));
    curve.imag() = column(fmt::format("lambda_{}_im", i));
    curves.eigenvalues.push_back(std::move(curve));
  }
  return curves;
}

TrainingCurves read_training_curves(const std::string& path) {
  return parse_training_curves(codegen::read_file(path), path);
}

namespace {

template <class T>
void read(const nlohmann::json& json, const char* field, T& value) {
  value = json.at(field).get<T>();
}

void read(const nlohmann::json& json, const char* field, ControlLoopResult::Quantiles& value) {
  const nlohmann::json& quantiles = json.at(field);
  read(quantiles, "p50", value.p50);
  read(quantiles, "p99", value.p99);
  read(quantiles, "p99_9", value.p99_9);
  read(quantiles, "max", value.max);
}

}  // namespace

ControlLoopResult parse_control_loop(std::string_view text, const std::string& name) {
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    ControlLoopResult result;
    read(json, "rate_hz", result.rate_hz);
    read(json, "ticks", result.ticks);
    read(json, "noise_std", result.noise_std);
    read(json, "rms_error", result.rms_error);
    read(json, "settled_rms_error", result.settled_rms_error);
    read(json, "missed_deadlines", result.missed_deadlines);
    read(json, "faults", result.faults);
    read(json, "outside_domain", result.outside_domain);
    read(json, "real_time_priority", result.real_time_priority);
    read(json, "memory_locked", result.memory_locked);
    read(json, "step_and_estimate_ns", result.step_and_estimate);
    read(json, "wake_up_lateness_ns", result.wake_up_lateness);
    for (const nlohmann::json& bucket : json.at("step_and_estimate_histogram")) {
      ControlLoopResult::Bucket& entry = result.histogram.emplace_back();
      read(bucket, "below_ns", entry.below_ns);
      read(bucket, "count", entry.count);
    }
    return result;
  } catch (const nlohmann::json::exception& error) {
    throw codegen::Error(fmt::format(
        "{}: is not the result of a control loop ({}); write it again with control_loop --json", name, error.what()));
  }
}

ControlLoopResult read_control_loop(const std::string& path) {
  constexpr std::size_t kMaxBytes = 1 << 20;  // a usual file has two kilobytes
  return parse_control_loop(codegen::read_file(path, kMaxBytes), path);
}

std::string nanoseconds(double ns) {
  if (ns < 1e3) return fmt::format("{} ns", fixed(ns, 0));
  return ns < 1e6 ? fmt::format("{} µs", significant(ns / 1e3)) : fmt::format("{} ms", significant(ns / 1e6));
}

}  // namespace nlo::trainer
