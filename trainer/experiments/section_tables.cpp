// SPDX-License-Identifier: MIT
#include "trainer/experiments/section_tables.h"

#include <fmt/format.h>

#include <algorithm>

#include "codegen/base/error.h"
#include "trainer/config/value.h"

namespace nlo::trainer {

std::string home_of_key(const std::string& name) {
  std::string home;
  for_each_section([&]<class Section>(const Section&) {
    const auto& known = keys<Section>();
    const bool knows = std::any_of(known.begin(), known.end(), [&](const auto& key) { return key.name == name; });
    if (home.empty() && knows) home = section_title<Section>();
  });
  return home;
}

LogConfig read_log_section(SectionTables& reader, const Toml& table) {
  LogConfig log;
  reader.read(table, "log", log, {"columns", "velocity_filter"});
  if (const Toml* filter = reader.section(table, "log.velocity_filter", "velocity_filter"))
    reader.read(*filter, "log.velocity_filter", log.velocity_filter);
  const auto columns = table.as_table().find("columns");
  if (columns == table.as_table().end()) return log;
  const std::string where = "[[log.columns]]";
  for (const Toml& column : list_of(columns->second, where, any())) {
    if (!column.is_table())
      throw codegen::Error(fmt::format("{}: {} is {}; each column is a table: {} with name, role, ... below it",
                                       reader.place(column), where, type_in_words(column), where));
    ColumnConfig& config = log.columns.emplace_back();
    reader.read(column, fmt::format("log.columns[{}]", log.columns.size() - 1), config);
    if (config.column.empty() && config.derivative_of.empty()) config.column = config.name;
  }
  return log;
}

}  // namespace nlo::trainer
