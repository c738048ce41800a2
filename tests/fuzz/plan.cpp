// SPDX-License-Identifier: MIT
// The plan of a sweep, up to its jobs and the experiment of the first job.
#include "trainer/app/sweep/plan.h"

#include <algorithm>

#include "tests/fuzz/fuzz.h"
#include "trainer/app/sweep/sweep_jobs.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/shipped.h"

using namespace nlo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  fuzzing::accepts([&] {
    const trainer::SweepPlan plan = trainer::parse_sweep_plan(fuzzing::text_of(bytes, size), "plan.toml");
    const std::vector<trainer::SweepJob> jobs = trainer::jobs_of(plan);
    fuzzing::require(!jobs.empty() && jobs.size() <= trainer::kMostSweepJobs, "a plan has jobs, and not too many");
    (void)trainer::job_line(jobs.back(), {plan.experiment, plan.data, "sweep", {}});
    const auto shipped = trainer::shipped_experiments();
    const auto named = std::find_if(shipped.begin(), shipped.end(), [&](const trainer::ShippedExperiment& experiment) {
      return experiment.name == plan.experiment;
    });
    if (named != shipped.end()) (void)trainer::parse_draft(named->text, "e.toml", jobs.front().assignments());
  });
  return 0;
}
