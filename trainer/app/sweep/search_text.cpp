// SPDX-License-Identifier: MIT
#include "trainer/app/sweep/search_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "trainer/base/number_text.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {
namespace {

/// Returns the number of rungs in which a candidate was trained to the end.
std::size_t rungs_of(const SearchRecord& record, std::size_t candidate) {
  std::size_t count = 0;
  for (const std::vector<Trial>& rung : record.rungs)
    for (const Trial& trial : rung) count += trial.candidate == candidate && trial.done ? 1 : 0;
  return count;
}

std::vector<std::size_t> order_of(const SearchRecord& record) {
  std::vector<std::size_t> order(record.candidates.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto error = [&](std::size_t candidate) {
    const Trial* last = record.last_of(candidate);
    return last != nullptr && last->error ? *last->error : std::numeric_limits<double>::infinity();
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const std::size_t far = rungs_of(record, a), other = rungs_of(record, b);
    return far != other ? far > other : error(a) < error(b);
  });
  return order;
}

}  // namespace

std::string title_of(const Candidate& candidate) {
  if (candidate.difference.empty()) return "unchanged";
  return candidate.title.empty() ? candidate.difference : candidate.title;
}

Table search_table(const SearchStory& story) {
  const SearchRecord& record = story.record;
  Table table{{"", "error", "steps", "rung", "multiply-adds", "flash [bytes]", "what is varied"}, {}};
  const std::size_t chosen = record.chosen().candidate;
  for (const std::size_t candidate : order_of(record)) {
    const Candidate& tried = record.candidates[candidate];
    const Trial* last = record.last_of(candidate);
    table.rows.push_back({candidate == chosen ? "*" : "",
                          last == nullptr ? "-"
                          : last->error   ? significant(last->error)
                                          : "diverged",
                          last == nullptr ? "-" : std::to_string(last->steps),
                          fmt::format("{}/{}", rungs_of(record, candidate), record.rungs.size()),
                          std::to_string(tried.cost.multiply_adds), std::to_string(tried.cost.flash_bytes),
                          title_of(tried)});
  }
  return table;
}

std::vector<std::string> search_findings(const SearchStory& story) {
  const SearchRecord& record = story.record;
  const Trial& chosen = record.chosen();
  std::vector<std::string> findings;
  const auto& last = record.rungs.back();
  const auto by_hand = std::find_if(last.begin(), last.end(), [](const Trial& trial) { return trial.candidate == 0; });
  const bool stands = record.by_hand_s > 0.0;
  if (stands && chosen.candidate == 0) {
    findings.push_back(fmt::format("{} stays as it is: none of {} candidates was better by more than 2 %.",
                                   story.experiment, record.candidates.size()));
  } else {
    std::string beside;
    if (stands && by_hand != last.end() && by_hand->error)
      beside = fmt::format(" The unchanged {} has {}.", story.experiment, significant(by_hand->error));
    findings.push_back(fmt::format("Found, out of {} candidates: {}. Its error is {}.{}", record.candidates.size(),
                                   title_of(record.candidates[chosen.candidate]), significant(chosen.error), beside));
  }
  if (!stands)
    findings.push_back(fmt::format("The unchanged {} exceeds the budget and was not tried.", story.experiment));
  else if (!record.by_hand_fits())
    findings.push_back(
        fmt::format("The unchanged {} takes {:.0f} s to train, more than half of the time, so all candidates, "
                    "including it, were trained for fewer steps. --minutes {:.0f} trains it in full.",
                    story.experiment, record.by_hand_s, std::ceil(2.2 * record.by_hand_s / 60.0)));
  findings.push_back(
      "Errors are norms over whole runs from the first sample, under the noise of the training, on validation runs "
      "that "
      "chose the candidate: on other runs its error may be larger. The report in this folder shows its error on test "
      "runs.");
  if (!story.held_out.empty())
    findings.push_back(
        fmt::format("[log] names no validation_files: the search chose by the training logs {}, which its "
                    "trainings left out; the found experiment is trained on all logs.",
                    story.held_out));
  return findings;
}

std::string search_text(const SearchStory& story) {
  constexpr std::size_t kShown = 8;
  const Table table = search_table(story);
  // The last column, because the varied settings may be long.
  const auto line = [](const std::vector<std::string>& cells) {
    return fmt::format("  {:1} {:>8} {:>7} {:>5} {:>14} {:>14}  {}\n", cells[0], cells[1], cells[2], cells[3], cells[4],
                       cells[5], cells[6]);
  };
  std::string text = line(table.headings);
  for (std::size_t i = 0; i < std::min(kShown, table.rows.size()); ++i) text += line(table.rows[i]);
  if (table.rows.size() > kShown) text += fmt::format("  and {} more in auto.html\n", table.rows.size() - kShown);
  text += "\n";
  for (const std::string& finding : search_findings(story)) text += finding + "\n";
  return text;
}

}  // namespace nlo::trainer
