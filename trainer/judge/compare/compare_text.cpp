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

std::vector<std::string> column_headings(const Comparison& comparison, const std::string& first) {
  std::vector<std::string> headings{first};
  for (const CompareColumn& column : comparison.columns) headings.push_back(column_title(column));
  return headings;
}

using CellText = std::function<std::string(const CompareCell&)>;

Table by_condition(const Comparison& comparison, const CellText& text) {
  Table table{column_headings(comparison, "condition"), {}};
  for (std::size_t i = 0; i < comparison.conditions.size(); ++i) {
    std::vector<std::string> row{condition_name(comparison.conditions[i])};
    for (const CompareCell& cell : comparison.cells[i]) row.push_back(cell.missing.empty() ? text(cell) : "-");
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// The column with the least error in a row, but for the floor.
std::size_t best_column(const Comparison& comparison, std::size_t condition) {
  std::size_t best = 0;
  for (std::size_t c = 1; c < comparison.columns.size(); ++c) {
    const CompareCell& cell = comparison.cell(condition, c);
    if (comparison.columns[c].name == "particle" || !cell.missing.empty()) continue;
    if (cell.mean() < comparison.cell(condition, best).mean()) best = c;
  }
  return best;
}

std::optional<std::size_t> column_named(const Comparison& comparison, std::string_view name) {
  for (std::size_t c = 0; c < comparison.columns.size(); ++c)
    if (comparison.columns[c].name == name) return c;
  return std::nullopt;
}

std::string first_observer(const Comparison& comparison) {
  const std::string& name = comparison.columns.front().name;
  return name == "observer" ? "The observer" : name;
}

/// The first observer against an EKF: conditions with the ratio of the errors.
struct Contest {
  std::string rival;
  std::vector<std::string> ahead, behind;
};

/// The first observer against the column of this name; none, where there is no such column.
std::optional<Contest> contest_with(const Comparison& comparison, std::string_view name, std::string_view in_words) {
  const auto column = column_named(comparison, name);
  if (!column) return std::nullopt;
  Contest contest{std::string(in_words), {}, {}};
  for (std::size_t i = 0; i < comparison.conditions.size(); ++i) {
    const CompareCell &own = comparison.cell(i, 0), &other = comparison.cell(i, *column);
    if (!other.missing.empty()) continue;
    (own.mean() < other.mean() ? contest.ahead : contest.behind)
        .push_back(fmt::format("{} ({})", condition_name(comparison.conditions[i]),
                               significant(own.mean() / other.mean(), 3)));
  }
  return contest;
}

std::vector<Contest> contests(const Comparison& comparison) {
  std::vector<Contest> result;
  for (const auto& [name, rival] :
       {std::pair{"ekf", "EKF as shipped"}, {"ekf_tuned", "EKF tuned for the very condition"}})
    if (auto contest = contest_with(comparison, name, rival)) result.push_back(std::move(*contest));
  return result;
}

std::string with_blanks(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

}  // namespace

std::string column_title(const CompareColumn& column) {
  if (column.is_observer) return column.name;
  const EstimatorWords* words = estimator_words(column.untuned_name());
  return (words == nullptr ? with_blanks(column.untuned_name()) : std::string(words->title)) +
         (column.is_tuned() ? ", tuned" : "");
}

std::string condition_name(const Condition& condition) {
  return with_blanks(condition.name);
}

Table error_table(const Comparison& comparison) {
  Table table = by_condition(comparison, [](const CompareCell& cell) { return to_text(cell.spread()); });
  for (std::size_t i = 0; i < comparison.conditions.size(); ++i) table.rows[i][1 + best_column(comparison, i)] += " *";
  return table;
}

Table worst_table(const Comparison& comparison) {
  return by_condition(comparison, [](const CompareCell& cell) { return significant(cell.worst); });
}

Table tuning_table(const Comparison& comparison) {
  Table table{{"condition"}, {}};
  std::vector<std::size_t> tuned;
  for (std::size_t c = 0; c < comparison.columns.size(); ++c)
    if (comparison.columns[c].is_tuned()) tuned.push_back(c);
  for (const std::size_t c : tuned) table.headings.push_back(column_title(comparison.columns[c]));
  for (std::size_t i = 0; i < comparison.conditions.size() && !tuned.empty(); ++i) {
    std::vector<std::string> row{condition_name(comparison.conditions[i])};
    for (const std::size_t c : tuned)
      row.push_back(comparison.cell(i, c).missing.empty() ? comparison.cell(i, c).tuning : "-");
    table.rows.push_back(std::move(row));
  }
  return table;
}

namespace {

/// "-" where nothing was counted.
std::string counted(double number, bool known = false) {
  return known || number > 0.0 ? fmt::format("{:.0f}", number) : "-";
}

}  // namespace

Table cost_table(const Comparison& comparison) {
  Table table{{"per sample", "operations", "functions", "state [bytes]", "constants [bytes]"}, {}};
  for (const CompareColumn& column : comparison.columns) {
    if (column.is_tuned()) continue;  // the same filter
    table.rows.push_back({column_title(column), counted(column.operations),
                          counted(column.functions, column.operations > 0.0), counted(column.state_bytes),
                          counted(column.constant_bytes)});
  }
  return table;
}

std::string comparison_conditions(const Comparison& comparison) {
  const CompareTest& test = comparison.test;
  return fmt::format(
      "plant {}, {} test seeds of {} runs of {} s each, seeds from {} on; norm of the error{}, transient "
      "included, ± standard error over the seeds{}",
      comparison.plant, test.seeds, test.trajectories, shortest_text(comparison.horizon_s), test.seed,
      comparison.normalised ? " of states over their deviation" : "",
      test.tune ? fmt::format("; tuned on {} other runs of each condition", test.tuning_trajectories) : "");
}

std::string comparison_summary(const Comparison& comparison) {
  std::vector<std::string> parts;
  for (const Contest& contest : contests(comparison))
    parts.push_back(fmt::format("{} of {} conditions than the {}", contest.ahead.size(),
                                contest.ahead.size() + contest.behind.size(), contest.rival));
  if (parts.empty()) return "";
  return fmt::format("{} errs less in {}.", first_observer(comparison), fmt::join(parts, ", and in "));
}

std::vector<std::string> comparison_findings(const Comparison& comparison) {
  std::vector<std::string> findings;
  for (const auto& [rival, ahead, behind] : contests(comparison))
    findings.push_back(fmt::format("{} is ahead of the {} in {} of {} conditions{}{}; behind in {}{}{}.",
                                   first_observer(comparison), rival, ahead.size(), ahead.size() + behind.size(),
                                   ahead.empty() ? "" : ": ", fmt::join(ahead, ", "), behind.size(),
                                   behind.empty() ? "" : ": ", fmt::join(behind, ", ")));
  for (const std::string& name : simple_names())
    if (const auto contest = contest_with(comparison, name, estimator_words(name)->title))
      if (!contest->behind.empty())
        findings.push_back(fmt::format("{} is behind the {}, which knows no plant, in {} of {} conditions: {}.",
                                       first_observer(comparison), contest->rival, contest->behind.size(),
                                       contest->ahead.size() + contest->behind.size(),
                                       fmt::join(contest->behind, ", ")));
  for (std::size_t c = 0; c < comparison.columns.size(); ++c) {
    std::map<std::string, std::vector<std::string>> reasons;
    int restarts = 0;
    for (std::size_t i = 0; i < comparison.conditions.size(); ++i) {
      const CompareCell& cell = comparison.cell(i, c);
      restarts += cell.restarts;
      if (!cell.missing.empty()) reasons[cell.missing].push_back(condition_name(comparison.conditions[i]));
    }
    const std::string name = column_title(comparison.columns[c]);
    for (const auto& [reason, names] : reasons)
      findings.push_back(names.size() == comparison.conditions.size()
                             ? fmt::format("{}: {}.", name, reason)
                             : fmt::format("{} has no figure for {}: {}.", name, fmt::join(names, ", "), reason));
    if (restarts > 0) findings.push_back(fmt::format("{} overflowed {} times and was reset.", name, restarts));
  }
  if (!comparison.left_out.empty())
    findings.push_back(
        fmt::format("Left out, as the plant has no parameters: {}.", fmt::join(comparison.left_out, ", ")));
  return findings;
}

std::string comparison_text(const Comparison& comparison) {
  std::string text = fmt::format("{}: {}\n\n{}", comparison.experiment, comparison_conditions(comparison),
                                 error_table(comparison).to_text(2));
  text += "  * the least of its row\n\n";
  for (const std::string& finding : comparison_findings(comparison)) text += fmt::format("  {}\n", finding);
  text += fmt::format("\nThe worst run of each\n{}", worst_table(comparison).to_text(2));
  if (const Table tuning = tuning_table(comparison); !tuning.rows.empty())
    text += fmt::format("\nTuned\n{}", tuning.to_text(2));
  text += fmt::format("\nWhat a step costs: counted (a multiply-add is two operations)\n{}",
                      cost_table(comparison).to_text(2));
  return text;
}

namespace {

Json cell_json(const Comparison& comparison, const CompareCell& cell) {
  if (!cell.missing.empty()) return {{"norm", nullptr}, {"missing", cell.missing}};
  Json json = {{"norm", json_number(cell.mean())}};
  json["standard_error"] = json_number(cell.spread().test_set_error);
  const auto each = static_cast<std::size_t>(comparison.test.trajectories);
  json["worst"] = {{"norm", json_number(cell.worst)},
                   {"seed", comparison.test.seed + cell.worst_run / each},
                   {"run", cell.worst_run % each}};
  json["by_seed"] = json_numbers(cell.norms);
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

std::string comparison_json(const Comparison& comparison) {
  const CompareTest& test = comparison.test;
  Json json = {{"experiment", comparison.experiment},
               {"plant", comparison.plant},
               {"seed", test.seed},
               {"seeds", test.seeds},
               {"trajectories", test.trajectories},
               {"horizon_s", json_number(comparison.horizon_s)},
               {"tuning_trajectories", test.tune ? Json(test.tuning_trajectories) : Json(nullptr)},
               {"norm_of", comparison.normalised ? "states over their standard deviation" : "states"}};
  Json& conditions = json["conditions"] = Json::object();
  for (std::size_t i = 0; i < comparison.conditions.size(); ++i) {
    Json& entry = conditions[comparison.conditions[i].name] = condition_json(comparison.conditions[i]);
    for (std::size_t c = 0; c < comparison.columns.size(); ++c)
      entry["columns"][comparison.columns[c].name] = cell_json(comparison, comparison.cell(i, c));
  }
  Json& cost = json["cost"] = Json::object();
  for (const CompareColumn& column : comparison.columns)
    cost[column.name] = {{"meaning", column.meaning},
                         {"operations", json_number(column.operations)},
                         {"functions", json_number(column.functions)},
                         {"state_bytes", json_number(column.state_bytes)},
                         {"constant_bytes", json_number(column.constant_bytes)}};
  json["left_out"] = comparison.left_out;
  json["findings"] = comparison_findings(comparison);
  return json_text(json) + "\n";
}

}  // namespace nlo::trainer
