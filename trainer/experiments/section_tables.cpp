// SPDX-License-Identifier: MIT
#include "trainer/experiments/section_tables.h"

#include <fmt/format.h>

#include <algorithm>

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
  log.columns = reader.read_list<ColumnConfig>(table, "log.columns", "columns");
  for (ColumnConfig& column : log.columns)
    if (column.column.empty() && column.derivative_of.empty()) column.column = column.name;
  return log;
}

}  // namespace nlo::trainer
