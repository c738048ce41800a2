// SPDX-License-Identifier: MIT
#include "trainer/app/sweep/results.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>

#include "trainer/base/number_text.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {
namespace {

constexpr std::array kStatuses = {JobStatus::kDone, JobStatus::kFailed, JobStatus::kUnfinished, JobStatus::kMissing,
                                  JobStatus::kOther};

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string cell = "\"";
  for (const char c : text) {
    if (c == '"') cell += '"';
    cell += c;
  }
  return cell + "\"";
}

std::string value_of(const SweepPoint& point, const std::string& key) {
  for (const SweepValue& value : point)
    if (value.key == key) return value.value;
  return "";
}

std::string title_of(const SweepPoint& point) {
  std::string title;
  for (const SweepValue& value : point)
    title += fmt::format("{}{}={}", title.empty() ? "" : " ", value.key.substr(value.key.rfind('.') + 1), value.value);
  return title.empty() ? "unchanged" : title;
}

PointResult point_result(const std::vector<const JobResult*>& of_seeds) {
  PointResult point;
  point.jobs = of_seeds.size();
  std::vector<double> errors;
  for (const JobResult* result : of_seeds) {
    if (result->status != JobStatus::kDone || !result->error) continue;
    ++point.done;
    errors.push_back(*result->error);
    if (!result->cost) continue;
    if (!point.cost) point.cost = result->cost;
    point.cost->multiply_adds = std::max(point.cost->multiply_adds, result->cost->multiply_adds);
    point.cost->flash_bytes = std::max(point.cost->flash_bytes, result->cost->flash_bytes);
    if (point.cost->ns && result->cost->ns) point.cost->ns = std::max(*point.cost->ns, *result->cost->ns);
  }
  if (point.done < point.jobs) return point;
  point.error = std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
  point.standard_error = standard_error(errors);
  return point;
}

/// Returns true if no other point is as good in both values and better in one.
bool on_front(const std::vector<PointResult>& points, const PointResult& point, CostOf cost) {
  const auto of = [cost](const PointResult& any) { return any.error && any.cost ? cost(*any.cost) : std::nullopt; };
  const std::optional<double> own = of(point);
  if (!own) return false;
  return std::none_of(points.begin(), points.end(), [&](const PointResult& other) {
    const std::optional<double> theirs = of(other);
    return theirs && *other.error <= *point.error && *theirs <= *own && (*other.error < *point.error || *theirs < *own);
  });
}

std::string number(const std::optional<double>& value) {
  return value ? shortest_text(*value) : "";
}

}  // namespace

std::optional<double> multiply_adds_of(const JobCost& cost) {
  return static_cast<double>(cost.multiply_adds);
}
std::optional<double> flash_bytes_of(const JobCost& cost) {
  return static_cast<double>(cost.flash_bytes);
}
std::optional<double> ns_of(const JobCost& cost) {
  return cost.ns;
}

std::string to_text(JobStatus status) {
  switch (status) {
    case JobStatus::kDone:
      return "done";
    case JobStatus::kFailed:
      return "failed";
    case JobStatus::kUnfinished:
      return "unfinished";
    case JobStatus::kMissing:
      return "missing";
    case JobStatus::kOther:
      return "other";
  }
  return "";
}

std::vector<PointResult> point_results(const std::vector<SweepJob>& jobs, const std::vector<JobResult>& results) {
  std::vector<std::vector<const JobResult*>> of_points;
  std::vector<std::string> titles;
  for (std::size_t j = 0; j < jobs.size(); ++j) {
    if (jobs[j].point >= of_points.size()) {
      of_points.emplace_back();
      titles.push_back(title_of(jobs[j].values));
    }
    of_points.back().push_back(&results[j]);
  }
  std::vector<PointResult> points;
  for (std::size_t i = 0; i < of_points.size(); ++i) {
    points.push_back(point_result(of_points[i]));
    points.back().title = titles[i];
  }
  mark_fronts(points);
  return points;
}

void mark_fronts(std::vector<PointResult>& points) {
  for (PointResult& point : points) {
    point.best_for_multiply_adds = on_front(points, point, multiply_adds_of);
    point.best_for_flash = on_front(points, point, flash_bytes_of);
    point.best_for_ns = on_front(points, point, ns_of);
  }
}

std::string sweep_csv(const std::vector<SweepJob>& jobs, const std::vector<JobResult>& results) {
  std::set<std::string> keys;
  for (const SweepJob& job : jobs)
    for (const SweepValue& value : job.values) keys.insert(value.key);
  std::string text = "job";
  for (const std::string& key : keys) text += "," + csv_cell(key);
  text += ",seed,status,validation_error,error,multiply_adds,flash_bytes,ns\n";
  for (std::size_t j = 0; j < jobs.size(); ++j) {
    const SweepJob& job = jobs[j];
    const JobResult& result = results[j];
    text += job.name;
    for (const std::string& key : keys) text += "," + csv_cell(value_of(job.values, key));
    text += fmt::format(",{},{},{},{}", job.seed ? std::to_string(*job.seed) : "", to_text(result.status),
                        number(result.validation_error), number(result.error));
    text += result.cost ? fmt::format(",{},{},{}\n", result.cost->multiply_adds, result.cost->flash_bytes,
                                      result.cost->ns ? significant(*result.cost->ns) : "")
                        : ",,,\n";
  }
  return text;
}

std::string sweep_text(const std::vector<SweepJob>& jobs, const std::vector<JobResult>& results,
                       const std::vector<PointResult>& points) {
  std::string counts;
  for (const JobStatus status : kStatuses) {
    const auto count = std::count_if(results.begin(), results.end(), [&](const auto& r) { return r.status == status; });
    if (count > 0) counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", count, to_text(status));
  }
  std::string text = fmt::format("{} jobs: {}\n\n", jobs.size(), counts);
  constexpr const char* kRow =
      "  {:>8} {:>9} {:>14} {:>14} {:>6} {:>6}  {:1} {}\n";  // last, because the varied settings may be long
  text += fmt::format(kRow, "error", "+-", "multiply-adds", "flash [bytes]", "ns", "done", "", "");
  for (const PointResult& point : points)
    text += fmt::format(
        kRow, significant(point.error), significant(point.standard_error),
        point.cost ? std::to_string(point.cost->multiply_adds) : "-",
        point.cost ? std::to_string(point.cost->flash_bytes) : "-",
        point.cost && point.cost->ns ? significant(*point.cost->ns) : "-", fmt::format("{}/{}", point.done, point.jobs),
        point.best_for_multiply_adds || point.best_for_flash || point.best_for_ns ? "*" : "", point.title);
  text +=
      "\nError: mean over the seeds with its standard error. A star marks the Pareto front: no other training is at "
      "least as accurate at a lower cost.\n";
  for (std::size_t j = 0; j < jobs.size(); ++j)
    if (!results[j].message.empty()) text += fmt::format("{}: {}\n", jobs[j].name, results[j].message);
  return text;
}

}  // namespace nlo::trainer
