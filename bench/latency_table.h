// SPDX-License-Identifier: MIT
// The tables of step_latency: the fastest times of benchmarks, and their ratios.
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "bench/ratios.h"

namespace nlo::bench {

/// Keeps the fastest repetition of each benchmark. Prints only a dot for each.
class FastestReporter : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context&) override { return true; }

  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration) continue;
      const std::string name = run.run_name.function_name;
      const auto slash = name.find('/');
      double& fastest = fastest_ns_[name.substr(0, slash)][name.substr(slash + 1)];
      const double ns = run.GetAdjustedRealTime();
      fastest = fastest > 0.0 ? std::min(fastest, ns) : ns;
    }
    std::fputc('.', stderr);
  }

  /// Returns the time [ns], or 0 if this benchmark did not run.
  double ns(const std::string& network, const std::string& what) const {
    const auto of_network = fastest_ns_.find(network);
    if (of_network == fastest_ns_.end()) return 0.0;
    const auto found = of_network->second.find(what);
    return found == of_network->second.end() ? 0.0 : found->second;
  }

  void print() const {
    for (const auto& [network, of_network] : fastest_ns_) {
      for (const auto& [what, ns] : of_network)
        std::printf("%-28s %-44s %9.1f ns\n", network.c_str(), what.c_str(), ns);
    }
  }

 private:
  std::map<std::string, std::map<std::string, double>> fastest_ns_;
};

/// Prints and stores the ratios of the benchmarks that ran.
class Table {
 public:
  Table(const FastestReporter& times, Ratios& ratios) : times_(times), ratios_(ratios) {}

  /// Adds a ratio: `times` times the fastest time of the benchmarks `over`, divided by the time of `under`.
  void add(const std::string& network, const std::vector<std::string>& over, const std::string& under, double target,
           const std::string& name, double times = 1.0) {
    double fastest = 0.0;
    for (const std::string& what : over) {
      const double ns = times_.ns(network, what);
      if (ns > 0.0 && (fastest == 0.0 || ns < fastest)) fastest = ns;
    }
    const double ns = times_.ns(network, under);
    if (fastest > 0.0 && ns > 0.0) add_value(network + ": " + name, times * fastest / ns, target);
  }

  void add_value(const std::string& name, double value, double target) {
    ratios_.add(name, value, target);
    std::printf("%-66s %6.2f", name.c_str(), value);
    if (target > 0.0) std::printf("   (%s %.2f)", value >= target ? "at least" : "MISSES", target);
    std::printf("\n");
  }

 private:
  const FastestReporter& times_;
  Ratios& ratios_;
};

}  // namespace nlo::bench
