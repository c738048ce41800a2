// SPDX-License-Identifier: MIT
#include "trainer/judge/compare/compare_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "trainer/base/number_text.h"
#include "trainer/judge/evaluation/estimator_words.h"
#include "trainer/judge/evaluation/json_numbers.h"

namespace nlo::trainer {
namespace {

std::vector<std::string> column_headings(const Study& study, const std::string& first) {
  std::vector<std::string> headings{first};
  for (const StudyEstimator& column : study.estimators) headings.push_back(column_title(column));
  return headings;
}

bool is_normalised(const Study& study) {
  return study.cell(0, 0).first().metrics.normalised;
}

using CellText = std::function<std::string(const StudyCell&)>;

Table by_condition(const Study& study, const CellText& text) {
  Table table{column_headings(study, "condition"), {}};
  for (std::size_t i = 0; i < study.test.conditions.size(); ++i) {
    std::vector<std::string> row{condition_name(study.test.conditions[i])};
    for (const StudyCell& cell : study.rows[i].cells) row.push_back(cell.missing.empty() ? text(cell) : "-");
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// Returns the column with the smallest error in a row, except the floor.
std::size_t best_column(const Study& study, std::size_t condition) {
  std::size_t best = 0;
  for (std::size_t c = 1; c < study.estimators.size(); ++c) {
    const StudyCell& cell = study.cell(condition, c);
    if (study.estimators[c].name == kParticle || !cell.missing.empty()) continue;
    if (norm_of(cell).mean < norm_of(study.cell(condition, best)).mean) best = c;
  }
  return best;
}

std::optional<std::size_t> column_named(const Study& study, std::string_view name) {
  for (std::size_t c = 0; c < study.estimators.size(); ++c)
    if (study.estimators[c].name == name) return c;
  return std::nullopt;
}

std::string first_observer(const Study& study) {
  const std::string& name = study.estimators.front().name;
  return name == "observer" ? "The observer" : name;
}

/// Compares the first observer with an EKF: conditions with the ratio of the errors.
struct Contest {
  std::string rival;
  std::vector<std::string> ahead, behind;
};

/// Compares the first observer with the column of this name. Returns nothing if there is no such column.
std::optional<Contest> contest_with(const Study& study, std::string_view name, std::string_view in_words) {
  const auto column = column_named(study, name);
  if (!column) return std::nullopt;
  Contest contest{std::string(in_words), {}, {}};
  for (std::size_t i = 0; i < study.test.conditions.size(); ++i) {
    const StudyCell &own = study.cell(i, 0), &other = study.cell(i, *column);
    if (!other.missing.empty()) continue;
    (norm_of(own).mean < norm_of(other).mean ? contest.ahead : contest.behind)
        .push_back(fmt::format("{} ({})", condition_name(study.test.conditions[i]),
                               significant(norm_of(own).mean / norm_of(other).mean, 3)));
  }
  return contest;
}

std::vector<Contest> contests(const Study& study) {
  std::vector<Contest> result;
  for (const auto& [name, rival] : {std::pair{"ekf", "EKF as shipped"}, {"ekf_tuned", "EKF tuned for this condition"}})
    if (auto contest = contest_with(study, name, rival)) result.push_back(std::move(*contest));
  return result;
}

std::string with_blanks(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

}  // namespace

std::string column_title(const StudyEstimator& column) {
  if (column.is_observer) return column.name;
  const EstimatorWords* words = estimator_words(column.untuned_name());
  return (words == nullptr ? with_blanks(column.untuned_name()) : std::string(words->title)) +
         (column.is_tuned() ? ", tuned" : "");
}

std::string condition_name(const Condition& condition) {
  return with_blanks(condition.name);
}

Table error_table(const Study& study) {
  Table table = by_condition(study, [](const StudyCell& cell) { return to_text(norm_of(cell)); });
  for (std::size_t i = 0; i < study.test.conditions.size(); ++i) table.rows[i][1 + best_column(study, i)] += " *";
  return table;
}

Table worst_table(const Study& study) {
  return by_condition(study, [](const StudyCell& cell) { return significant(worst_run(cell).norm); });
}

Table tuning_table(const Study& study) {
  Table table{{"condition"}, {}};
  std::vector<std::size_t> tuned;
  for (std::size_t c = 0; c < study.estimators.size(); ++c)
    if (study.estimators[c].is_tuned()) tuned.push_back(c);
  for (const std::size_t c : tuned) table.headings.push_back(column_title(study.estimators[c]));
  for (std::size_t i = 0; i < study.test.conditions.size() && !tuned.empty(); ++i) {
    std::vector<std::string> row{condition_name(study.test.conditions[i])};
    for (const std::size_t c : tuned) row.push_back(study.cell(i, c).missing.empty() ? study.cell(i, c).tuning : "-");
    table.rows.push_back(std::move(row));
  }
  return table;
}

namespace {

/// Returns the number, or "-" if nothing was counted.
std::string counted(double number, bool known = false) {
  return known || number > 0.0 ? fmt::format("{:.0f}", number) : "-";
}

}  // namespace

Table cost_table(const Study& study) {
  Table table{{"per sample", "operations", "functions", "state [bytes]", "constants [bytes]"}, {}};
  for (const StudyEstimator& column : study.estimators) {
    if (column.is_tuned()) continue;  // costs as much as the untuned filter
    table.rows.push_back({column_title(column), counted(column.operations),
                          counted(column.functions, column.operations > 0.0), counted(column.state_bytes),
                          counted(column.constant_bytes)});
  }
  return table;
}

std::string comparison_conditions(const Study& study) {
  const StudyTest& test = study.test;
  return fmt::format(
      "plant {}, {} test seeds of {} runs of {} s each, seeds from {} on; norm of the error{}, transient "
      "included, ± standard error over the seeds{}",
      study.plant, test.test_sets, test.trajectories, shortest_text(study.horizon_s), test.seed,
      is_normalised(study) ? " of states divided by their deviation" : "",
      test.tune ? fmt::format("; tuned on {} other runs of each condition", test.tuning_trajectories) : "");
}

std::string comparison_summary(const Study& study) {
  std::vector<std::string> parts;
  for (const Contest& contest : contests(study))
    parts.push_back(fmt::format("{} of {} conditions than the {}", contest.ahead.size(),
                                contest.ahead.size() + contest.behind.size(), contest.rival));
  if (parts.empty()) return "";
  return fmt::format("{} has a smaller error in {}.", first_observer(study), fmt::join(parts, ", and in "));
}

std::vector<std::string> comparison_findings(const Study& study) {
  std::vector<std::string> findings;
  for (const auto& [rival, ahead, behind] : contests(study))
    findings.push_back(fmt::format("{} is ahead of the {} in {} of {} conditions{}{}; behind in {}{}{}.",
                                   first_observer(study), rival, ahead.size(), ahead.size() + behind.size(),
                                   ahead.empty() ? "" : ": ", fmt::join(ahead, ", "), behind.size(),
                                   behind.empty() ? "" : ": ", fmt::join(behind, ", ")));
  for (const std::string& name : simple_names())
    if (const auto contest = contest_with(study, name, estimator_words(name)->title))
      if (!contest->behind.empty())
        findings.push_back(
            fmt::format("{} is behind the {}, which does not know the plant, in {} of {} conditions: {}.",
                        first_observer(study), contest->rival, contest->behind.size(),
                        contest->ahead.size() + contest->behind.size(), fmt::join(contest->behind, ", ")));
  for (std::size_t c = 0; c < study.estimators.size(); ++c) {
    std::map<std::string, std::vector<std::string>> reasons;
    int restarts = 0;
    for (std::size_t i = 0; i < study.test.conditions.size(); ++i) {
      const StudyCell& cell = study.cell(i, c);
      restarts += cell.restarts;
      if (!cell.missing.empty()) reasons[cell.missing].push_back(condition_name(study.test.conditions[i]));
    }
    const std::string name = column_title(study.estimators[c]);
    for (const auto& [reason, names] : reasons)
      findings.push_back(names.size() == study.test.conditions.size()
                             ? fmt::format("{}: {}.", name, reason)
                             : fmt::format("{} has no result for {}: {}.", name, fmt::join(names, ", "), reason));
    if (restarts > 0) findings.push_back(fmt::format("{} overflowed {} times and was reset.", name, restarts));
  }
  if (!study.left_out.empty())
    findings.push_back(
        fmt::format("Left out, because the plant has no parameters: {}.", fmt::join(study.left_out, ", ")));
  for (const std::string& why : study.impossible) findings.push_back(fmt::format("Left out: {}", why));
  return findings;
}

std::string comparison_text(const Study& study) {
  std::string text =
      fmt::format("{}: {}\n\n{}", study.experiment, comparison_conditions(study), error_table(study).to_text(2));
  text += "  * the smallest of its row\n\n";
  for (const std::string& finding : comparison_findings(study)) text += fmt::format("  {}\n", finding);
  text += fmt::format("\nThe worst run of each column\n{}", worst_table(study).to_text(2));
  if (const Table tuning = tuning_table(study); !tuning.rows.empty())
    text += fmt::format("\nTuned\n{}", tuning.to_text(2));
  text += fmt::format("\nCost of a step in counted operations (a multiply-add is two operations)\n{}",
                      cost_table(study).to_text(2));
  return text;
}

namespace {

Json cell_json(const Study& study, const StudyCell& cell) {
  if (!cell.missing.empty()) return {{"norm", nullptr}, {"missing", cell.missing}};
  const Spread norm = norm_of(cell);
  const WorstRun worst = worst_run(cell);
  Json json = {{"norm", json_number(norm.mean)}};
  json["standard_error"] = json_number(norm.test_set_error);
  json["worst"] = {{"norm", json_number(worst.norm)}, {"seed", study.test.seed + worst.set}, {"run", worst.run}};
  for (const Evaluation& evaluation : cell.evaluations.front())
    json["by_seed"].push_back(json_number(evaluation.metrics.norm));
  if (!cell.tuning.empty()) json["tuning"] = cell.tuning;
  if (cell.restarts > 0) json["restarts"] = cell.restarts;
  return json;
}

Json condition_json(const Condition& condition) {
  Json json = {{"title", condition_title(condition)}, {"noise", format_noise(condition.noise)}};
  if (condition.parameter_factor != 1.0) json["parameter_factor"] = condition.parameter_factor;
  for (const auto& [name, value] : condition.parameters) json["parameters"][name] = value;
  if (!condition.process_noise.empty()) json["process_noise"] = condition.process_noise;
  if (condition.box_scale != 1.0) json["box_scale"] = condition.box_scale;
  if (!condition.changes.empty()) json["set"] = condition.changes;
  if (!condition.inputs.empty()) json["input"] = condition.inputs;
  if (!condition.input_noise.none()) json["input_noise"] = format_noise(condition.input_noise);
  return json;
}

}  // namespace

std::string comparison_json(const Study& study) {
  const StudyTest& test = study.test;
  Json json = {{"experiment", study.experiment},
               {"plant", study.plant},
               {"seed", test.seed},
               {"seeds", test.test_sets},
               {"trajectories", test.trajectories},
               {"horizon_s", json_number(study.horizon_s)},
               {"tuning_trajectories", test.tune ? Json(test.tuning_trajectories) : Json(nullptr)},
               {"norm_of", is_normalised(study) ? "states over their standard deviation" : "states"}};
  Json& conditions = json["conditions"] = Json::object();
  for (std::size_t i = 0; i < study.test.conditions.size(); ++i) {
    Json& entry = conditions[study.test.conditions[i].name] = condition_json(study.test.conditions[i]);
    for (std::size_t c = 0; c < study.estimators.size(); ++c)
      entry["columns"][study.estimators[c].name] = cell_json(study, study.cell(i, c));
  }
  Json& cost = json["cost"] = Json::object();
  for (const StudyEstimator& column : study.estimators)
    cost[column.name] = {{"meaning", column.meaning},
                         {"operations", json_number(column.operations)},
                         {"functions", json_number(column.functions)},
                         {"state_bytes", json_number(column.state_bytes)},
                         {"constant_bytes", json_number(column.constant_bytes)}};
  json["left_out"] = study.left_out;
  json["impossible"] = study.impossible;
  json["findings"] = comparison_findings(study);
  return json_text(json) + "\n";
}

}  // namespace nlo::trainer
