// SPDX-License-Identifier: MIT
// The result of a benchmark for tracking: ratios instead of times, because times depend on the machine and its load.
// Every benchmark takes `--json FILE`; bench/run.sh collects the files, and bench/compare judges and tabulates them.
// Every benchmark also takes `--smoke`, which runs everything briefly to show that it runs.
//   {"bench": "step_latency", "compiler": "GCC 12.2.0", "flags": "-O3 -march=native",
//    "ratios": {"3-50x4-2 tanh: Eigen / nlo": 2.4}, "targets": {"3-50x4-2 tanh: Eigen / nlo": 2.0}}
#pragma once

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#if !defined(NLO_BENCH_FLAGS)
#define NLO_BENCH_FLAGS "unknown"
#endif

namespace nlo::bench {

class Ratios {
 public:
  /// Removes `--json FILE` and `--smoke` from the arguments, so that other parsers need not know them. Without FILE
  /// nothing is written. Ends the program (2) if the name of FILE is missing.
  ///   bench  the program's name; two builds of one source have two names
  Ratios(std::string bench, int& argc, char** argv) : bench_(std::move(bench)) {
    int kept = 1;
    for (int i = 1; i < argc; ++i) {
      if (std::string_view(argv[i]) == "--smoke") {
        smoke_ = true;
        continue;
      }
      if (std::string_view(argv[i]) != "--json") {
        argv[kept++] = argv[i];
        continue;
      }
      if (++i == argc) {
        std::fprintf(stderr, "%s: --json wants the name of a file to write\n", bench_.c_str());
        std::exit(2);
      }
      path_ = argv[i];
    }
    argc = kept;
    argv[argc] = nullptr;
  }

  bool smoke() const { return smoke_; }

  /// Adds a ratio of two measurements of one run: the time of the other code over our time, so that larger is better.
  ///   name    numerator and denominator, the same in each run
  ///   target  least acceptable ratio; 0: none
  void add(const std::string& name, double value, double target = 0.0) {
    ratios_[name] = value;
    if (target > 0.0) targets_[name] = target;
  }

  /// Writes FILE atomically. Returns the exit code of main: 0, or 1 if it cannot be written or a ratio is not a
  /// positive number.
  int write() const {
    for (const auto& [name, value] : ratios_.items()) {
      const double ratio = value.get<double>();
      if (std::isfinite(ratio) && ratio > 0.0) continue;
      std::fprintf(stderr, "%s: \"%s\" is %g, no ratio of two times\n", bench_.c_str(), name.c_str(), ratio);
      return 1;
    }
    if (path_.empty()) return 0;
    const Json all{{"bench", bench_},
                   {"compiler", compiler()},
                   {"flags", NLO_BENCH_FLAGS},
                   {"ratios", ratios_},
                   {"targets", targets_}};
    const std::string unfinished = path_ + ".unfinished";
    std::error_code error;
    {
      std::ofstream file(unfinished);
      file << all.dump(2) << '\n';
      if (!file.flush()) error = {errno != 0 ? errno : EIO, std::generic_category()};
    }
    if (!error) std::filesystem::rename(unfinished, path_, error);
    if (!error) return 0;
    std::fprintf(stderr, "%s: cannot write %s: %s\n", bench_.c_str(), path_.c_str(), error.message().c_str());
    return 1;
  }

 private:
  using Json = nlohmann::ordered_json;

  static std::string compiler() {
#if defined(__clang__)
    return "clang " __clang_version__;
#elif defined(__GNUC__)
    return "GCC " __VERSION__;
#else
    return "unknown";
#endif
  }

  std::string bench_, path_;
  bool smoke_ = false;
  Json ratios_ = Json::object(), targets_ = Json::object();
};

}  // namespace nlo::bench
