// SPDX-License-Identifier: MIT
// Helpers for tests of the loader: columns in one line, a small log of a made-up rig, and a fixture that loads a log
// from a text.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "tests/support/scratch_directory.h"
#include "tests/support/thrown_message.h"
#include "trainer/config/experiment.h"
#include "trainer/data/log_dataset.h"

namespace nlo::trainer {

inline constexpr double kTurn = 2.0 * std::numbers::pi;

struct ColumnOptions {
  std::string column = {}, unit = {};
  double wrap = 0.0;
  Encoding encoding = Encoding::kUnwrap;
  std::string derivative_of = {};
};

inline ColumnConfig column(const std::string& name, ColumnRole role, const ColumnOptions& options = {}) {
  ColumnConfig config;
  config.name = name;
  config.role = role;
  config.column = options.column;
  config.unit = options.unit;
  config.wrap = options.wrap;
  config.encoding = options.encoding;
  config.derivative_of = options.derivative_of;
  return config;
}

/// A wheel that swings: phi = 2 sin(2 t) + 3 t, sampled at 200 Hz with 5 % of clock jitter, from t = 3.1 s on, logged
/// wrapped to (-pi, pi], with shuffled columns, one of them text.
struct SyntheticLog {
  int samples = 600;
  double period_s = 0.005;

  double time_s(int k) const { return period_s * (k + 0.05 * std::sin(1.7 * k)); }
  static double angle(double t) { return 2.0 * std::sin(2.0 * t) + 3.0 * t; }
  static double velocity(double t) { return 4.0 * std::cos(2.0 * t) + 3.0; }

  std::string csv() const {
    std::string text = "comment,phi,torque,time\n";
    for (int k = 0; k < samples; ++k) {
      const double t = time_s(k);
      char line[160];
      std::snprintf(line, sizeof line, "\"row, %d\",%.12g,%.3g,%.12g\n", k, std::remainder(angle(t), kTurn), 0.01 * k,
                    3.1 + t);
      text += line;
    }
    return text;
  }

  /// Measures phi and estimates its velocity.
  static LogConfig config() {
    LogConfig log;
    log.columns = {column("t", ColumnRole::kTime, {.column = "time", .unit = "s"}),
                   column("phi", ColumnRole::kOutput, {.unit = "rad", .wrap = kTurn}),
                   column("omega", ColumnRole::kState, {.unit = "rad/s", .derivative_of = "phi"})};
    log.velocity_filter.cutoff_hz = 20.0;
    log.sample_period_s = 0.005;
    return log;
  }
};

inline constexpr double kPrinted = 1e-10;  // the synthetic log is written with 12 digits

/// Loads one log from a text.
class LoadingLogs : public ::testing::Test {
 protected:
  Dataset load(const LogConfig& config, const std::string& csv) {
    scratch_.write("log.csv", csv);
    return load_logs(config, scratch_.path(), {"log.csv"}, &report_);
  }
  std::string error_in(const LogConfig& config, const std::string& csv) {
    return thrown_message([&] { load(config, csv); });
  }

  ScratchDirectory scratch_;
  LogReport report_;
  SyntheticLog log_;
};

}  // namespace nlo::trainer
