// SPDX-License-Identifier: MIT
// A small valid experiment to change in one place, and the error message of its reader.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/thrown_message.h"
#include "trainer/config/experiment.h"
#include "trainer/experiments/load_experiment.h"

namespace nlo::trainer {

inline const std::string kPlantExperiment = R"(name = "small"

[plant]
model = "van_der_pol"
parameters = { mu = 1.5 }

[simulation]
horizon_s = 10.0
trajectories = 4
initial_low = [-1, -1]
initial_high = [1, 1]

[observer]
eigenvalues = [-1.0, -2.0]
pairs = [[-0.5, 1.0]]
hold = "first_order"

[training]
steps = 10
noise = "gaussian:0.5"
)";

inline const std::string kLogExperiment = R"(name = "rig"

[log]
train_files = ["a.csv"]

[[log.columns]]
name = "t"
role = "time"

[[log.columns]]
name = "angle"
role = "output"
unit = "rad"
wrap = "2pi"

[[log.columns]]
name = "rate"
role = "state"
derivative_of = "angle"

[observer]
eigenvalues = [-10.0]
output_injection = "unit_gain"
start = "steady"
features = "latent_minus_output"
)";

/// Returns `text` with the only occurrence of `old` replaced. Throws if `old` is missing: the test would then test
/// nothing.
inline std::string with(std::string text, const std::string& old, const std::string& replacement) {
  const auto at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  if (at != std::string::npos) text.replace(at, old.size(), replacement);
  return text;
}

inline std::string error_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return thrown_message([&] { parse_experiment(text, "e.toml", overrides); });
}

/// A broken text, its place, and the beginning and a part of the message.
struct Row {
  std::string old, replacement, place, message;
};

inline void expect_rows(const std::string& text, const std::vector<Row>& rows) {
  for (const Row& row : rows) {
    SCOPED_TRACE(row.replacement);
    const std::string message = error_of(with(text, row.old, row.replacement));
    EXPECT_THAT(message, testing::StartsWith(row.place + ": "));
    EXPECT_THAT(message, testing::HasSubstr(row.message));
  }
}

}  // namespace nlo::trainer
