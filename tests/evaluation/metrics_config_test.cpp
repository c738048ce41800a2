// SPDX-License-Identifier: MIT
#include "trainer/evaluation/metrics_config.h"

#include <gtest/gtest.h>

namespace nlo::trainer {
namespace {

TEST(MetricsConfig, KnowsARateOfDecayWhereThereIsAD) {
  Experiment experiment;
  experiment.observer.eigenvalues = {-100.0};
  EXPECT_EQ(metrics_config(experiment, 50.0).windows[2].from_s, 0.05);
  for (const char* structure : {"general", "luenberger"}) {
    experiment.observer.structure = structure;  // F of (11) starts from eigenvalues and leaves them
    EXPECT_EQ(metrics_config(experiment, 50.0).windows[2].from_s, 10.0) << structure;
  }
}

}  // namespace
}  // namespace nlo::trainer
