// SPDX-License-Identifier: MIT
#include "tests/claims/ledger.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <stdexcept>
#include <toml.hpp>

#include "trainer/base/number_text.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::claims {

namespace {

using trainer::shortest_text;
using Texts = std::vector<std::string>;

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error(what);
}

std::optional<double> number(const toml::value& entry, const char* key) {
  if (!entry.contains(key)) return std::nullopt;
  const toml::value& value = entry.at(key);
  return value.is_integer() ? static_cast<double>(value.as_integer()) : value.as_floating();
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + "\"";
}

std::string quoted(const Texts& texts) {
  Texts each;
  for (const std::string& text : texts) each.push_back(quoted(text));
  return fmt::format("[{}]", fmt::join(each, ", "));
}

/// shortest_text() may print an integer, but a float in TOML needs a point.
std::string toml_float(double value) {
  const std::string text = shortest_text(value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

const Claim& claim_of(const Ledger& ledger, const std::string& id, const std::string& where) {
  for (const Claim& claim : ledger.claims)
    if (claim.id == id) return claim;
  fail(fmt::format("{}: there is no claim \"{}\"", where, id));
}

std::string filled(const Ledger& ledger, const std::string& cell, const std::string& where) {
  std::string text;
  for (std::size_t at = 0; at < cell.size();) {
    const std::size_t open = cell.find('{', at), close = cell.find('}', at);
    if (open == std::string::npos || close == std::string::npos) return text + cell.substr(at);
    text += cell.substr(at, open - at) + figure_text(claim_of(ledger, cell.substr(open + 1, close - open - 1), where));
    at = close + 1;
  }
  return text;
}

std::string table_text(const Ledger& ledger, const Table& table) {
  std::string text = fmt::format("| {} |\n|{}\n", fmt::join(table.heading, " | "), [&] {
    std::string rule;
    for (std::size_t i = 0; i < table.heading.size(); ++i) rule += "---|";
    return rule;
  }());
  for (const Texts& row : table.rows) {
    Texts cells;
    for (const std::string& cell : row) cells.push_back(filled(ledger, cell, "table " + table.id));
    text += fmt::format("| {} |\n", fmt::join(cells, " | "));
  }
  return text;
}

void check(const Ledger& ledger) {
  std::set<std::string> experiments, claims, tables;
  for (const Experiment& e : ledger.experiments)
    if (!experiments.insert(e.id).second) fail(fmt::format("experiment \"{}\" is given twice", e.id));
  for (const Claim& c : ledger.claims) {
    if (!claims.insert(c.id).second) fail(fmt::format("claim \"{}\" is given twice", c.id));
    if (!c.run.starts_with("reproduce") && !c.run.starts_with("identify ") && !experiments.contains(c.experiment))
      fail(fmt::format("claim \"{}\": there is no experiment \"{}\"", c.id, c.experiment));
    if (!c.tolerance && !c.at_least && !c.at_most)
      fail(fmt::format("claim \"{}\" can't fail: give it a tolerance, at_least or at_most", c.id));
  }
  for (const Table& t : ledger.tables) {
    if (!tables.insert(t.id).second) fail(fmt::format("table \"{}\" is given twice", t.id));
    for (const Texts& row : t.rows)
      if (row.size() != t.heading.size()) fail(fmt::format("table \"{}\": a row has {} cells", t.id, row.size()));
    (void)table_text(ledger, t);  // throws if a table names an unknown claim
  }
}

/// Returns the fields of a line of CSV, quoted as `nlo reproduce` writes them.
std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> result{""};
  bool inside = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') {
      if (inside && i + 1 < line.size() && line[i + 1] == '"')
        result.back() += line[++i];
      else
        inside = !inside;
    } else if (line[i] == ',' && !inside) {
      result.emplace_back();
    } else {
      result.back() += line[i];
    }
  }
  return result;
}

}  // namespace

Ledger read_ledger(const std::string& text, const std::string& file) {
  std::istringstream stream(text);
  const toml::value root = toml::parse(stream, file);
  Ledger ledger;
  for (const toml::value& e : toml::find_or<std::vector<toml::value>>(root, "experiment", {}))
    ledger.experiments.push_back(
        {toml::find<std::string>(e, "id"), toml::find<std::string>(e, "train"),
         toml::find_or<std::string>(e, "data", ""), toml::find_or<int>(e, "seeds", 3),
         toml::find_or<bool>(e, "quick", false), toml::find_or<Texts>(e, "set", Texts{}),
         toml::find_or<Texts>(e, "flight_inputs", Texts{}), toml::find_or<std::string>(e, "flight_noise", "none"),
         toml::find_or<bool>(e, "trains_on_data", true), toml::find_or<bool>(e, "watched", false)});
  for (const toml::value& c : toml::find_or<std::vector<toml::value>>(root, "claim", {})) {
    Claim claim{toml::find<std::string>(c, "id"),
                toml::find_or<std::string>(c, "experiment", ""),
                toml::find<std::string>(c, "run"),
                toml::find<std::string>(c, "metric"),
                number(c, "tolerance"),
                number(c, "at_least"),
                number(c, "at_most")};
    claim.slow = toml::find_or<bool>(c, "slow", false);
    claim.measured = c.contains("value");
    claim.value = number(c, "value").value_or(0.0);
    claim.spread = number(c, "spread").value_or(0.0);
    ledger.claims.push_back(std::move(claim));
  }
  for (const toml::value& t : toml::find_or<std::vector<toml::value>>(root, "table", {}))
    ledger.tables.push_back({toml::find<std::string>(t, "id"), toml::find<std::string>(t, "file"),
                             toml::find<Texts>(t, "heading"), toml::find<std::vector<Texts>>(t, "rows")});
  check(ledger);
  return ledger;
}

std::string write_ledger(const Ledger& ledger) {
  std::string text =
      "# The ledger of results: every estimation figure in README and docs, the command that makes it, and how far it "
      "may\n"
      "# move. `./test.sh --claims` runs all of them and fails when one has moved; `build/release/tests/claims/claims\n"
      "# --update` writes the figures here and into the tables of the pages. value: mean over the training seeds; "
      "spread:\n"
      "# their population deviation. Fields are explained in tests/claims/ledger.h.\n";
  for (const Experiment& e : ledger.experiments) {
    text += fmt::format("\n[[experiment]]\nid = {}\ntrain = {}\n", quoted(e.id), quoted(e.train));
    if (!e.data.empty()) text += fmt::format("data = {}\n", quoted(e.data));
    text += fmt::format("seeds = {}\n", e.seeds);
    if (e.quick) text += "quick = true\n";
    if (!e.trains_on_data) text += "trains_on_data = false\n";
    if (e.watched) text += "watched = true\n";
    if (!e.set.empty()) text += fmt::format("set = {}\n", quoted(e.set));
    if (e.flight_noise != "none") text += fmt::format("flight_noise = {}\n", quoted(e.flight_noise));
    if (!e.flight_inputs.empty()) text += fmt::format("flight_inputs = {}\n", quoted(e.flight_inputs));
  }
  for (const Claim& c : ledger.claims) {
    text += fmt::format("\n[[claim]]\nid = {}\n", quoted(c.id));
    if (!c.experiment.empty()) text += fmt::format("experiment = {}\n", quoted(c.experiment));
    text += fmt::format("run = {}\nmetric = {}\n", quoted(c.run), quoted(c.metric));
    for (const auto& [key, value] :
         {std::pair{"tolerance", c.tolerance}, {"at_least", c.at_least}, {"at_most", c.at_most}})
      if (value) text += fmt::format("{} = {}\n", key, toml_float(*value));
    if (c.slow) text += "slow = true\n";
    if (c.measured) text += fmt::format("value = {}\nspread = {}\n", toml_float(c.value), toml_float(c.spread));
  }
  for (const Table& t : ledger.tables) {
    text += fmt::format("\n[[table]]\nid = {}\nfile = {}\nheading = {}\nrows = [\n", quoted(t.id), quoted(t.file),
                        quoted(t.heading));
    for (const Texts& row : t.rows) text += fmt::format("  {},\n", quoted(row));
    text += "]\n";
  }
  return text;
}

std::string figure_text(const Claim& claim) {
  if (!claim.measured) return "not measured";
  return trainer::to_text(trainer::Spread{claim.value, claim.spread});
}

std::string with_tables(const Ledger& ledger, const std::string& file, std::string page) {
  static const std::string kEnd = "<!-- end of results -->";
  for (const Table& table : ledger.tables) {
    if (table.file != file) continue;
    const std::string begin = fmt::format("<!-- results {} -->", table.id);
    const std::size_t from = page.find(begin);
    const std::size_t to = from == std::string::npos ? from : page.find(kEnd, from);
    if (to == std::string::npos) fail(fmt::format("{}: has no \"{}\" ... \"{}\"", file, begin, kEnd));
    page = page.substr(0, from + begin.size()) + "\n\n" + table_text(ledger, table) + "\n" + page.substr(to);
  }
  static const std::string kBegin = "<!-- results ";
  for (std::size_t at = page.find(kBegin); at != std::string::npos; at = page.find(kBegin, at + 1)) {
    const std::string id = page.substr(at + kBegin.size(), page.find(" -->", at) - at - kBegin.size());
    if (std::none_of(ledger.tables.begin(), ledger.tables.end(),
                     [&](const Table& table) { return table.id == id && table.file == file; }))
      fail(fmt::format("{}: the ledger has no table \"{}\"", file, id));
  }
  return page;
}

std::string disagreement(const Claim& claim, double measured, bool quick) {
  if (!std::isfinite(measured)) return "is not finite";
  if (claim.at_least && measured < *claim.at_least)
    return fmt::format("is {:.4g}, below {}", measured, shortest_text(*claim.at_least));
  if (claim.at_most && measured > *claim.at_most)
    return fmt::format("is {:.4g}, above {}", measured, shortest_text(*claim.at_most));
  if (!claim.tolerance) return "";
  if (!claim.measured) return fmt::format("is {:.4g}, and the ledger has no value yet", measured);
  const double allowed = (quick ? 2.0 : 1.0) * *claim.tolerance;
  const double moved = std::abs(measured - claim.value) / std::abs(claim.value);
  if (moved <= allowed) return "";
  return fmt::format("moved from {} to {:.4g}, by {:.1f} % where {:.1f} % is allowed", shortest_text(claim.value),
                     measured, 100.0 * moved, 100.0 * allowed);
}

std::pair<double, double> reproduced(const Claim& claim, const std::string& csv) {
  std::istringstream lines(csv);
  std::string line;
  while (std::getline(lines, line)) {
    const std::vector<std::string> f = fields(line);
    if (f.size() > 7 && fmt::format("{} | {} | {} | {}", f[0], f[1], f[2], f[3]) == claim.metric)
      return {std::stod(f[6]), std::stod(f[7])};
  }
  throw std::runtime_error(fmt::format("{}: the item has no row {}", claim.id, claim.metric));
}

}  // namespace nlo::claims
