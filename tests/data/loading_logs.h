// SPDX-License-Identifier: MIT
// A fixture that loads one log from a text.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "tests/data/testing.h"
#include "trainer/data/log_dataset.h"

namespace nlo::trainer {

inline constexpr double kPrinted = 1e-10;  // the synthetic log is written with 12 digits

class LoadingLogs : public ::testing::Test {
 protected:
  Dataset load(const LogConfig& config, const std::string& csv) {
    scratch_.write("log.csv", csv);
    return load_logs(config, scratch_.path(), {"log.csv"}, &report_);
  }
  std::string error_in(const LogConfig& config, const std::string& csv) {
    return error_of([&] { load(config, csv); });
  }

  ScratchDirectory scratch_;
  LogReport report_;
  SyntheticLog log_;
};

}  // namespace nlo::trainer
