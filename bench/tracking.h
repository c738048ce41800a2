// SPDX-License-Identifier: MIT
// Ratios over time: the files of several runs (ratios.h) are combined into one result per machine, with medians; two
// results are compared; one result is printed as a table for docs/appendix/performance.md.
//   {"machine": {"cpu": ..., "cores": 2, "system": ...},
//    "benches": {"step_latency": {"compiler": ..., "flags": ..., "runs": 5,
//                                 "ratios": {"name": {"median": 2.4, "lowest": 2.3, "highest": 2.5, "target": 2.0}}}}}
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace nlo::bench {

using Json = nlohmann::ordered_json;

/// Returns a description of this machine: CPU, cores, system.
Json describe_machine();

/// Returns the medians of every ratio over all runs of its benchmark. `runs` are files of ratios.h. Throws
/// std::runtime_error if one is not such a file, or if two runs of a benchmark were built differently.
Json collect(const std::vector<Json>& runs, const Json& machine);

struct Comparison {
  std::string table;        ///< one line per ratio
  int fallen = 0;           ///< number of ratios that fell by more than the tolerance
  int missing = 0;          ///< number of ratios of `before` that `now` does not have
  std::string differences;  ///< differences of machine, compiler and flags that may change ratios
};

/// Compares two results of collect().
///   tolerance  share by which a median may fall, 0.1: 10 %
Comparison compare(const Json& before, const Json& now, double tolerance);

/// Returns a result as Markdown: the machine, and a table for each benchmark.
std::string markdown(const Json& result);

}  // namespace nlo::bench
