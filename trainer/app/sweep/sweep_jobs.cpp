// SPDX-License-Identifier: MIT
#include "trainer/app/sweep/sweep_jobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>

#include "codegen/base/error.h"
#include "trainer/base/printable.h"
#include "trainer/learn/training/checkpoint.h"

namespace nlo::trainer {
namespace {

bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.';
}

/// Turns "[16, 32]" into "16-32", which is a valid folder name on all systems.
std::string folder_text(const std::string& value) {
  std::string text;
  for (const char c : value) {
    if (is_plain(c) || (c == '-' && (text.empty() || text.back() != '-'))) {
      text += c;
    } else if (!text.empty() && text.back() != '-') {
      text += '-';
    }
  }
  while (!text.empty() && text.back() == '-') text.pop_back();
  return text;
}

std::string name_of(const SweepJob& job) {
  constexpr std::size_t kLongest = 80;  // a file system allows 255, but a reader prefers less
  std::string name, identity;
  for (const SweepValue& value : job.values) {
    name += fmt::format("{}-{}_", value.key.substr(value.key.rfind('.') + 1), folder_text(value.value));
    identity += fmt::format("{}={}\n", value.key, value.value);
  }
  if (name.size() > kLongest) name = name.substr(0, kLongest) + "_";
  if (job.seed) {
    name += fmt::format("seed-{}_", *job.seed);
    identity += fmt::format("seed={}\n", *job.seed);
  }
  constexpr std::uint64_t kTenDigits = 0xffffffffffULL;
  return fmt::format("{}{:010x}", name, fingerprint(identity.data(), identity.size()) & kTenDigits);
}

}  // namespace

std::vector<std::string> SweepJob::assignments() const {
  std::vector<std::string> result;
  for (const SweepValue& value : values) result.push_back(value.key + "=" + value.value);
  return result;
}

std::vector<SweepJob> jobs_of(const SweepPlan& plan) {
  std::vector<SweepJob> jobs;
  const auto add = [&](std::size_t point, std::optional<unsigned long long> seed) {
    SweepJob& job = jobs.emplace_back(SweepJob{plan.points[point], seed, point, ""});
    job.name = name_of(job);
  };
  for (std::size_t i = 0; i < plan.points.size(); ++i) {
    if (plan.seeds.empty()) add(i, std::nullopt);
    for (const unsigned long long seed : plan.seeds) add(i, seed);
  }
  return jobs;
}

std::string job_line(const SweepJob& job, const SweepPlaces& places) {
  std::string line = "nlo train " + shell_word(places.experiment);
  if (!places.data.empty()) line += " --data " + shell_word(places.data);
  for (const std::string& assignment : job.assignments()) line += " --set " + shell_word(assignment);
  if (job.seed) line += fmt::format(" --seed {}", *job.seed);
  if (places.threads) line += fmt::format(" --threads {}", *places.threads);
  line += " -o " + shell_word(places.folder + "/" + job.name) + " --resume -q";
  if (line.find('\n') != std::string::npos)
    throw codegen::Error("a path has a line break, and a job is one line; rename it");
  return line;
}

Shard parse_shard(const std::string& text) {
  const auto slash = text.find('/');
  const auto number = [&](std::size_t from, std::size_t to) -> std::optional<std::size_t> {
    std::size_t value = 0;
    const char *begin = text.data() + from, *end = text.data() + to;
    const auto [stop, error] = std::from_chars(begin, end, value);
    return error == std::errc{} && stop == end ? std::optional(value) : std::nullopt;
  };
  if (slash != std::string::npos) {
    const auto index = number(0, slash), count = number(slash + 1, text.size());
    if (index && count && *index < *count) return {*index, *count};
  }
  throw codegen::Error(fmt::format(
      "--shard {}: is not I/N with I from 0 to N - 1; write --shard 0/4 for the first of four parts", text));
}

}  // namespace nlo::trainer
