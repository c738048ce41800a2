// SPDX-License-Identifier: MIT
// What the tests of the loader share: a scratch directory, the message of an error, columns in one line, and a small
// log of a rig that does not exist.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/config/experiment.h"

namespace nlo::trainer {

inline constexpr double kTurn = 2.0 * std::numbers::pi;

/// A directory of the running test's own, removed with what is in it.
class ScratchDirectory {
 public:
  ScratchDirectory() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::path(::testing::TempDir()) /
            (std::string("nlo_data_") + test->test_suite_name() + "_" + test->name());
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;
  ~ScratchDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }

  std::string path() const { return path_.string(); }
  std::string file(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name, std::ios::binary) << text;
    return file(name);
  }

 private:
  std::filesystem::path path_;
};

/// The message of the codegen::Error that `action` throws; empty when it throws none.
template <typename Action>
std::string error_of(Action&& action) {
  try {
    std::forward<Action>(action)();
  } catch (const codegen::Error& error) {
    return error.what();
  }
  return {};
}

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

/// A wheel that swings: phi = 2 sin(2 t) + 3 t, sampled at 200 Hz with a clock that jitters by 5 %, logged wrapped to
/// (-pi, pi] from t = 3.1 s on, with columns in an odd order and one of text.
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

  /// Measures phi, estimates its velocity.
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

}  // namespace nlo::trainer
