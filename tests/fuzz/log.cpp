// SPDX-License-Identifier: MIT
// A log with the experiment that describes its columns: TOML, the line "#--log", CSV.
#include <cmath>
#include <fstream>

#include "tests/fuzz/fuzz.h"
#include "tests/training/training_testing.h"
#include "trainer/data/log_dataset.h"
#include "trainer/experiments/load_experiment.h"

using namespace nlo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static const ScratchDirectory directory;
  static const std::string path = directory.path("log.csv");
  const fuzzing::Parts parts = fuzzing::split_at(fuzzing::text_of(bytes, size), "\n#--log\n");
  fuzzing::accepts([&] {
    const trainer::Experiment experiment = trainer::parse_draft(parts.before, "e.toml").experiment;
    if (!experiment.log) return;
    std::ofstream(path, std::ios::binary | std::ios::trunc) << parts.after;
    trainer::LogReport report;
    const trainer::Dataset data = trainer::load_logs(*experiment.log, "", {path}, &report);
    (void)trainer::to_text(report);
    fuzzing::require(std::isfinite(data.sample_period_s) && data.sample_period_s > 0.0, "a sample period is positive");
    for (const trainer::Trajectory& run : data.trajectories)
      fuzzing::require(run.time_s.allFinite() && run.outputs.allFinite() && run.states.allFinite() &&
                           run.inputs.allFinite() && run.weight.allFinite(),
                       "what is loaded is finite");
  });
  return 0;
}
