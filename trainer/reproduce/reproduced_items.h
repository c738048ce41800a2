// SPDX-License-Identifier: MIT
// Everything that `nlo reproduce` can make: the paper's tables and figures, each with its experiments and the analysis
// of their models.
//
// To add an item: add its experiments to trainer/experiments/paper/, an analysis to a file of this folder, and an entry
// to reproduced_items.cpp.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "trainer/reproduce/section.h"
#include "trainer/reproduce/workbench.h"

namespace nlo::trainer::reproduction {

struct Item {
  std::string_view name;           ///< on the command line and of its CSV file: "table1", "figure-reg-traj"
  std::string_view example;        ///< "example1", "example2", "example3", "exams": the group it can be asked for by
  std::string_view title;          ///< title of its section
  std::string_view label;          ///< \label of the paper's figure or table, or another source of its numbers
  std::string_view paper_reports;  ///< the paper's figures and claims
  /// Names in trainer/experiments/paper/, or with their folder, or shipped with nlo. Changes of an experiment may
  /// follow, each as " section.key=value".
  std::vector<std::string_view> experiments;
  double analysis_s = 1.0;  ///< approximate time at full size with 3 seeds, for the progress bar
  Section (*analyse)(const Workbench& bench);
  std::string_view logs = "";  ///< folder of its logs in --data; empty: it simulates
};

std::span<const Item> items();

/// Returns the items of "all", of an example, or with one name, in the paper's order. An unknown name throws
/// codegen::Error with the nearest known one.
std::vector<const Item*> select_items(const std::string& what);

}  // namespace nlo::trainer::reproduction
