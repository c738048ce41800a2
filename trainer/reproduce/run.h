// SPDX-License-Identifier: MIT
// `nlo reproduce` as a function: trains missing models, analyses them, and writes the page and the CSV files.
#pragma once

#include <atomic>
#include <string>
#include <utility>
#include <vector>

#include "trainer/app/jobs/run_jobs.h"
#include "trainer/reproduce/reproduced_items.h"
#include "trainer/reproduce/section.h"
#include "trainer/reproduce/workbench.h"

namespace nlo::trainer::reproduction {

struct Request {
  std::string what = "all";
  std::string directory = "reproduction";
  std::string data;  ///< folder that contains the folders of logs; empty: items with logs are left out
  Size size;
  bool quick = false;  ///< true: the page says that the numbers are only approximate
  int seeds = 3;
  int threads = 0;  ///< 0: all cores; does not affect a result
  const std::atomic<bool>* stop = nullptr;
};

struct Result {
  bool interrupted = false;  ///< true: only the cache was written
  JobsResult trainings;
  std::vector<std::pair<const Item*, Section>> sections;
  std::vector<std::string> left_out;  ///< a sentence for each item whose logs are missing
};

/// Writes DIR/reproduction.html, DIR/<item>.csv and DIR/cache/<hash>/. Throws codegen::Error before anything is written
/// for an unknown item, or for a single item whose logs are missing. Also throws it if a training diverges or a file
/// cannot be written.
Result reproduce(const Request& request, JobsProgress& progress);

}  // namespace nlo::trainer::reproduction
