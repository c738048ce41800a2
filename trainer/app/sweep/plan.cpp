// SPDX-License-Identifier: MIT
#include "trainer/app/sweep/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/base/number_text.h"
#include "trainer/config/section_reader.h"

namespace nlo::trainer {
namespace {

/// A choice of a job: the values of a key, or of keys that change together.
using Axis = std::vector<SweepPoint>;

const std::vector<Key<SweepPlan>>& plan_keys() {
  static const std::vector<Key<SweepPlan>> kKeys = {
      key("experiment", &SweepPlan::experiment, any(), "experiment file that is varied, or a shipped name"),
      key("data", &SweepPlan::data, any(), "directory of the logs that [log] of the experiment names"),
      key("seeds", &SweepPlan::seeds, any(), "seeds of the trainings; none: the seed of the experiment"),
  };
  return kKeys;
}

const std::vector<Key<SweepTest>>& test_keys() {
  static const std::vector<Key<SweepTest>> kKeys = {
      {"noise",
       "as in [training]",
       "noise of the outputs in the test runs",
       [](SweepTest& test, const Toml& value, const std::string& where) {
         read_value(value, where, any(), test.noise.emplace());
       },
       {}},
      key("seed", &SweepTest::seed, any(), "seed of the test runs"),
      key("trajectories", &SweepTest::trajectories, between(1, 100000), "number of test runs"),
  };
  return kKeys;
}

std::string home_of(const std::string& name) {
  if (has_key(plan_keys(), name)) return "the top of the plan";
  return has_key(test_keys(), name) ? "[test]" : "";
}

[[noreturn]] void fail(const Toml& value, const std::string& what) {
  throw codegen::Error(fmt::format("{}: {}", place_of(value), what));
}

std::string value_text(const Toml& value) {
  const auto joined = [](std::string text, const std::string& next) {
    return text + (text.empty() ? "" : ", ") + next;
  };
  switch (value.type()) {
    case toml::value_t::boolean:
      return value.as_boolean() ? "true" : "false";
    case toml::value_t::integer:
      return std::to_string(value.as_integer());
    case toml::value_t::floating: {
      const std::string text = shortest_text(value.as_floating());
      return text.find_first_not_of("-0123456789") == std::string::npos ? text + ".0" : text;
    }
    case toml::value_t::string:
      return toml_text(value.as_string().str);
    case toml::value_t::array: {
      std::string text;
      for (const Toml& element : value.as_array()) text = joined(text, value_text(element));
      return "[" + text + "]";
    }
    case toml::value_t::table: {
      std::string text;
      for (const auto& [name, member] : members_in_order(value))
        text = joined(text, toml_text(name) + " = " + value_text(*member));
      return "{" + text + "}";
    }
    default:
      fail(value, fmt::format("{} is not a value of an experiment", type_in_words(value)));
  }
}

using Visit = std::function<void(const std::string& key, const Toml& value)>;

/// Visits the keys below `table` and its subtables. [grid.training] with `steps` and [grid] with `training.steps` give
/// the same key.
void walk(const Toml& table, const std::string& prefix, const Visit& visit) {
  for (const auto& [name, value] : members_in_order(table)) {
    const auto fits = [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.';
    };
    if (name.empty() || !std::all_of(name.begin(), name.end(), fits))
      fail(*value, fmt::format("{} is not a key of an experiment; write for example training.steps", toml_text(name)));
    const std::string key = prefix.empty() ? name : prefix + "." + name;
    if (key == "seed") fail(*value, "the seed is varied by seeds = [1, 2, 3] at the top of the plan");
    if (value->is_table()) {
      walk(*value, key, visit);
    } else {
      visit(key, *value);
    }
  }
}

/// Returns an axis for each key.
std::vector<Axis> axes_of(const Toml& table, const std::string& title) {
  std::vector<Axis> axes;
  walk(table, "", [&](const std::string& key, const Toml& value) {
    if (!value.is_array())
      fail(value, fmt::format("{} {} is {}; it must be a list of the values to try: {} = [{}]", title, key,
                              type_in_words(value), key, value_text(value)));
    if (value.as_array().empty()) fail(value, fmt::format("{} {} has no values; give at least one", title, key));
    Axis& axis = axes.emplace_back();
    for (const Toml& element : value.as_array()) axis.push_back({{key, value_text(element), place_of(element)}});
  });
  return axes;
}

/// Returns keys that change together as one axis.
Axis zipped(const std::vector<Axis>& axes, const std::string& place) {
  if (axes.empty()) throw codegen::Error(fmt::format("{}: [[zip]] has no keys; give two that change together", place));
  Axis axis(axes.front().size());
  for (const Axis& each : axes) {
    const SweepValue &first = axes.front().front().front(), &own = each.front().front();
    if (each.size() != axis.size())
      throw codegen::Error(fmt::format(
          "{}: [[zip]] {} has {} values, but {} has {}; keys that change together need the same number of values",
          own.place, own.key, each.size(), first.key, axis.size()));
    for (std::size_t i = 0; i < axis.size(); ++i) axis[i].push_back(each[i].front());
  }
  return axis;
}

/// Sorts the keys alphabetically. Throws for a key that is given twice.
SweepPoint ordered(SweepPoint point) {
  std::stable_sort(point.begin(), point.end(), [](const auto& a, const auto& b) { return a.key < b.key; });
  const auto twice =
      std::adjacent_find(point.begin(), point.end(), [](const auto& a, const auto& b) { return a.key == b.key; });
  if (twice != point.end())
    throw codegen::Error(fmt::format("{}: {} is varied already, in {}; leave one of them out", (twice + 1)->place,
                                     twice->key, twice->place));
  return point;
}

/// Returns every combination, with the last axis changing fastest.
std::vector<SweepPoint> combinations(const std::vector<Axis>& axes) {
  std::vector<SweepPoint> points(1);
  for (const Axis& axis : axes) {
    std::vector<SweepPoint> next;
    for (const SweepPoint& point : points)
      for (const SweepPoint& values : axis) {
        next.push_back(point);
        next.back().insert(next.back().end(), values.begin(), values.end());
      }
    points = std::move(next);
  }
  return points;
}

/// Returns the tables of [[name]]; empty if the plan has none.
std::vector<const Toml*> tables_of(const Toml& root, const std::string& name) {
  std::vector<const Toml*> tables;
  const auto found = root.as_table().find(name);
  if (found == root.as_table().end()) return tables;
  for (const Toml& table : list_of(found->second, "[[" + name + "]]", {.at_most = kMostSweepJobs})) {
    if (!table.is_table())
      fail(table,
           fmt::format("{} is {}; each one is a table: [[{}]] with keys below it", name, type_in_words(table), name));
    tables.push_back(&table);
  }
  return tables;
}

void check_count(const SweepPlan& plan, const std::vector<Axis>& axes, std::size_t more) {
  std::string sizes;
  double count = axes.empty() && more > 0 ? 0.0 : 1.0;  // a double cannot overflow here
  for (const Axis& axis : axes) {
    count *= static_cast<double>(axis.size());
    sizes += fmt::format("{}{}", sizes.empty() ? "" : " x ", axis.size());
  }
  if (more > 0) sizes += fmt::format("{}{} points", sizes.empty() ? "" : " + ", more);
  const std::size_t seeds = std::max<std::size_t>(plan.seeds.size(), 1);
  count = (count + static_cast<double>(more)) * static_cast<double>(seeds);
  if (count > static_cast<double>(kMostSweepJobs))
    throw codegen::Error(
        fmt::format("{}: {:.0f} jobs ({}, {} seed{}); at most {} are allowed: leave values out, or make several plans",
                    plan.place, count, sizes, seeds, seeds == 1 ? "" : "s", kMostSweepJobs));
}

}  // namespace

SweepPlan parse_sweep_plan(std::string_view text, const std::string& filename) {
  const Toml root = parse_toml(text, filename);
  Places places(filename);
  SectionReader reader(filename, places, home_of);
  SweepPlan plan;
  plan.place = filename;
  reader.read(root, "", "a plan", plan_keys(), plan, {"grid", "zip", "point", "test"});
  if (plan.experiment.empty())
    throw codegen::Error(fmt::format(
        "{}: the plan has no experiment; begin it with experiment = \"FILE.toml\", or with a shipped name", filename));
  std::vector<unsigned long long> seeds = plan.seeds;
  std::sort(seeds.begin(), seeds.end());
  if (const auto twice = std::adjacent_find(seeds.begin(), seeds.end()); twice != seeds.end())
    throw codegen::Error(fmt::format("{}: seeds has {} twice; leave one out", places.of("seeds"), *twice));
  if (const Toml* test = reader.section(root, "test", "test"))
    reader.read(*test, "test", "[test]", test_keys(), plan.test);

  std::vector<Axis> axes;
  if (const Toml* grid = reader.section(root, "grid", "grid")) axes = axes_of(*grid, "[grid]");
  for (const Toml* table : tables_of(root, "zip"))
    axes.push_back(zipped(axes_of(*table, "[[zip]]"), reader.place(*table)));
  const std::vector<const Toml*> more = tables_of(root, "point");
  check_count(plan, axes, more.size());
  if (!axes.empty() || more.empty()) plan.points = combinations(axes);
  for (const Toml* table : more) {
    SweepPoint& point = plan.points.emplace_back();
    walk(*table, "", [&](const std::string& key, const Toml& value) {
      point.push_back({key, value_text(value), place_of(value)});
    });
  }
  for (SweepPoint& point : plan.points) point = ordered(std::move(point));
  return plan;
}

SweepPlan read_sweep_plan(const std::string& path) {
  return parse_sweep_plan(codegen::read_file(path, kMaxConfigBytes), path);
}

}  // namespace nlo::trainer
