// SPDX-License-Identifier: MIT
// Ratios over time: the files of several runs (ratios.h) become one result per machine, with medians; two results are
// compared; one result is a table for docs/appendix/performance.md.
//   {"machine": {"cpu": ..., "cores": 2, "system": ...},
//    "benches": {"step_latency": {"compiler": ..., "flags": ..., "runs": 5,
//                                 "ratios": {"name": {"median": 2.4, "lowest": 2.3, "highest": 2.5, "target": 2.0}}}}}
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace nlo::bench {

using Json = nlohmann::ordered_json;

/// Describes this machine: CPU, cores, system.
Json describe_machine();

/// Medians of every ratio over all runs of its benchmark; `runs` are files of ratios.h. Throws std::runtime_error when
/// one is none, or when two runs of a benchmark were built differently.
Json collect(const std::vector<Json>& runs, const Json& machine);

struct Comparison {
  std::string table;        ///< one line per ratio
  int fallen = 0;           ///< ratios that fell by more than the tolerance
  int missing = 0;          ///< ratios of `before` that `now` has no more
  std::string differences;  ///< differences of machine, compiler and flags that may change ratios
};

/// Compares two results of collect().
///   tolerance  share by which a median may fall, 0.1: 10 %
Comparison compare(const Json& before, const Json& now, double tolerance);

/// A result as Markdown: the machine, and a table per benchmark.
std::string markdown(const Json& result);

}  // namespace nlo::bench
