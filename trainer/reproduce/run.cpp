// SPDX-License-Identifier: MIT
#include "trainer/reproduce/run.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/reproduce/numbers_csv.h"
#include "trainer/reproduce/page.h"
#include "trainer/reproduce/planned_trainings.h"

namespace nlo::trainer::reproduction {
namespace {

struct Interrupted {};

/// Returns the time of an item's analysis at this size [s], from its time at full size.
double analysis_cost_s(const Item& item, const Request& request) {
  return item.analysis_s * request.seeds / 3.0 * request.size.test_trajectories / kFullSize.test_trajectories;
}

/// Returns a sentence about missing logs; empty if none are missing.
std::string no_logs(const Item& item, const std::string& data) {
  if (item.logs.empty()) return "";
  if (data.empty())
    return fmt::format("{} needs logs: name the folder that holds {}/ by --data FOLDER", item.name, item.logs);
  const std::string folder = data + "/" + std::string(item.logs);
  return std::filesystem::is_directory(folder)
             ? ""
             : fmt::format("{} needs its logs, but there is no {}", item.name, folder);
}

void write_section(const Item& item, const Section& section, const std::string& directory) {
  const std::string base = directory + "/" + std::string(item.name);
  const std::string numbers = numbers_csv(section);
  if (!numbers.empty()) codegen::write_file_atomically(base + (section.csv.empty() ? ".csv" : "-numbers.csv"), numbers);
  if (!section.csv.empty()) codegen::write_file_atomically(base + ".csv", section.csv);
}

}  // namespace

Result reproduce(const Request& request, JobsProgress& progress) {
  Result result;
  std::vector<const Item*> selected;
  for (const Item* item : select_items(request.what)) {
    if (std::string why = no_logs(*item, request.data); why.empty())
      selected.push_back(item);
    else
      result.left_out.push_back(std::move(why));
  }
  if (selected.empty()) throw codegen::Error(result.left_out.front());
  const std::vector<PlannedTraining> planned = plan_trainings(selected, request.size, request.seeds, request.data);
  for (const Item* item : selected) progress.expect(analysis_cost_s(*item, request));
  std::filesystem::create_directories(request.directory);
  Workbench bench;
  bench.data = request.data;
  result.trainings = train_planned(
      planned, request.directory + "/cache",
      {.threads = request.threads, .keep_going = true, .stop = request.stop, .progress = &progress}, bench.models);
  result.interrupted = result.trainings.left > 0;
  if (result.interrupted) return result;

  bench.size = request.size;
  bench.seeds = request.seeds;
  bench.threads = request.threads;
  for (const PlannedTraining& training : planned)
    bench.experiments.emplace(training.experiment, training.draft.experiment);
  try {
    for (const Item* item : selected) {
      double done = 0.0;
      bench.progress = [&](double share) {
        if (request.stop != nullptr && request.stop->load()) throw Interrupted{};
        progress.advance(analysis_cost_s(*item, request) * (share - done), fmt::format("measuring {}", item->name));
        done = share;
      };
      bench.progress(0.0);
      result.sections.emplace_back(item, item->analyse(bench));
      bench.progress(1.0);
    }
  } catch (const Interrupted&) {
    result.interrupted = true;
    return result;
  }
  for (const auto& [item, section] : result.sections) write_section(*item, section, request.directory);
  codegen::write_file_atomically(request.directory + "/reproduction.html", page_html(request, result, bench));
  progress.finish();
  return result;
}

}  // namespace nlo::trainer::reproduction
