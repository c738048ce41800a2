// SPDX-License-Identifier: MIT
#include "bench/tracking.h"

#include <sys/utsname.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <stdexcept>
#include <thread>

namespace nlo::bench {

namespace {

/// Returns the value after "key : value" in /proc/cpuinfo; empty if there is none.
std::string cpu_info(const std::string& key) {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const auto colon = line.find(':');
    if (colon == std::string::npos || line.compare(0, line.find_last_not_of(" \t", colon - 1) + 1, key) != 0) continue;
    const auto value = line.find_first_not_of(" \t", colon + 1);
    return value == std::string::npos ? "" : line.substr(value);
  }
  return {};
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t n = values.size();
  return 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

std::string text(const char* format, double value) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

/// Returns a text about a build or a machine, or "unknown" if it is missing.
std::string word(const Json& object, const char* key) {
  return object.value(key, std::string("unknown"));
}

std::string padded(std::string cell, std::size_t width) {
  if (cell.size() < width) cell.append(width - cell.size(), ' ');
  return cell;
}

/// Escapes bars, which would end a cell in Markdown.
std::string cell(const std::string& name) {
  std::string out;
  for (const char c : name) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}

}  // namespace

Json describe_machine() {
  std::string cpu = cpu_info("model name");
  // Virtual machines often show only the family instead of the model.
  if (!cpu_info("cpu family").empty()) cpu += ", family " + cpu_info("cpu family") + " model " + cpu_info("model");
  utsname system{};
  uname(&system);
  return {{"cpu", cpu.empty() ? std::string(system.machine) : cpu},
          {"cores", std::max(1U, std::thread::hardware_concurrency())},
          {"system", std::string(system.sysname) + ' ' + system.machine}};
}

Json collect(const std::vector<Json>& runs, const Json& machine) {
  struct Samples {
    std::vector<double> values;
    double target = 0.0;
  };
  struct Bench {
    std::string compiler, flags;
    int runs = 0;
    std::vector<std::string> order;
    std::map<std::string, Samples> ratios;
  };
  std::vector<std::string> order;
  std::map<std::string, Bench> benches;
  for (const Json& run : runs) {
    if (!run.is_object() || !run.contains("bench") || !run.contains("ratios"))
      throw std::runtime_error("not written by a benchmark: no \"bench\" or no \"ratios\"");
    const auto name = run.at("bench").get<std::string>();
    Bench& bench = benches[name];
    if (bench.runs++ == 0) {
      order.push_back(name);
      bench.compiler = word(run, "compiler");
      bench.flags = word(run, "flags");
    }
    if (bench.compiler != word(run, "compiler") || bench.flags != word(run, "flags"))
      throw std::runtime_error("runs of " + name + " were built differently; measure them with one build");
    for (const auto& [ratio, value] : run.at("ratios").items()) {
      if (!bench.ratios.contains(ratio)) bench.order.push_back(ratio);
      Samples& samples = bench.ratios[ratio];
      samples.values.push_back(value.get<double>());
      if (run.contains("targets")) samples.target = run.at("targets").value(ratio, 0.0);
    }
  }
  Json result{{"machine", machine}, {"benches", Json::object()}};
  for (const std::string& name : order) {
    const Bench& bench = benches.at(name);
    Json& out = result["benches"][name];
    out = {{"compiler", bench.compiler}, {"flags", bench.flags}, {"runs", bench.runs}, {"ratios", Json::object()}};
    for (const std::string& ratio : bench.order) {
      const Samples& samples = bench.ratios.at(ratio);
      const auto [lowest, highest] = std::ranges::minmax(samples.values);
      Json& entry = out["ratios"][ratio];
      entry = {{"median", median(samples.values)}, {"lowest", lowest}, {"highest", highest}};
      if (samples.target > 0.0) entry["target"] = samples.target;
    }
  }
  return result;
}

Comparison compare(const Json& before, const Json& now, double tolerance) {
  Comparison result;
  const auto note_difference = [&](const std::string& what, const std::string& a, const std::string& b) {
    if (a != b) result.differences += what + ": " + a + " before, " + b + " now\n";
  };
  note_difference("cpu", word(before.at("machine"), "cpu"), word(now.at("machine"), "cpu"));
  const auto line = [&](const std::string& outcome, double old_value, double new_value, const std::string& name) {
    const auto number = [](double value) { return value > 0.0 ? text("%8.3f", value) : std::string("       -"); };
    const std::string change =
        old_value > 0.0 && new_value > 0.0 ? text("%+7.1f %%", 100.0 * (new_value / old_value - 1.0)) : "        -";
    result.table +=
        padded(outcome, 8) + number(old_value) + "  " + number(new_value) + "  " + change + "  " + name + '\n';
  };
  result.table = padded("", 8) + "  before       now     change  ratio (larger is better)\n";
  const Json& benches_now = now.at("benches");
  for (const auto& [name, bench] : before.at("benches").items()) {
    const Json nothing = Json::object();
    const Json& bench_now = benches_now.contains(name) ? benches_now.at(name) : nothing;
    if (bench_now.contains("ratios")) {
      note_difference(name + ", compiler", word(bench, "compiler"), word(bench_now, "compiler"));
      note_difference(name + ", flags", word(bench, "flags"), word(bench_now, "flags"));
    }
    for (const auto& [ratio, entry] : bench.at("ratios").items()) {
      const auto old_value = entry.at("median").get<double>();
      const std::string label = name + ": " + ratio;
      if (!bench_now.contains("ratios") || !bench_now.at("ratios").contains(ratio)) {
        ++result.missing;
        line("MISSING", old_value, 0.0, label);
        continue;
      }
      const auto new_value = bench_now.at("ratios").at(ratio).at("median").get<double>();
      const bool fell = new_value < old_value * (1.0 - tolerance);
      if (fell) ++result.fallen;
      line(fell ? "FELL" : "", old_value, new_value, label);
    }
  }
  for (const auto& [name, bench] : benches_now.items()) {
    for (const auto& [ratio, entry] : bench.at("ratios").items()) {
      const Json& old = before.at("benches");
      if (old.contains(name) && old.at(name).at("ratios").contains(ratio)) continue;
      line("new", 0.0, entry.at("median").get<double>(), name + ": " + ratio);
    }
  }
  return result;
}

std::string markdown(const Json& result) {
  const Json& machine = result.at("machine");
  std::string out = word(machine, "cpu") + ", " + std::to_string(machine.value("cores", 0)) + " cores, " +
                    word(machine, "system") + ".\n";
  for (const auto& [name, bench] : result.at("benches").items()) {
    out += "\n`" + name + "`, " + word(bench, "compiler") + ", `" + word(bench, "flags") + "`, median of " +
           std::to_string(bench.value("runs", 0)) + " runs (lowest to highest):\n\n";
    out += "| ratio | measured | asked |\n|---|---|---|\n";
    for (const auto& [ratio, entry] : bench.at("ratios").items()) {
      const auto at = [&entry = entry](const char* key) { return entry.at(key).get<double>(); };
      out += "| " + cell(ratio) + " | " + text("%.2f", at("median")) + " (" + text("%.2f", at("lowest")) + " to " +
             text("%.2f", at("highest")) + ") | ";
      if (entry.contains("target")) {
        out += text("%.2f", at("target")) + (at("median") >= at("target") ? ", met" : ", **not met**");
      }
      out += " |\n";
    }
  }
  return out;
}

}  // namespace nlo::bench
