// SPDX-License-Identifier: MIT
// The items that `nlo reproduce` can make: the paper's tables and figures, and exams. Each item has experiments and an
// analysis of their models.
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
  std::string_view name;           ///< name on the command line and of its CSV file: "table1", "figure-reg-traj"
  std::string_view example;        ///< its group on the command line: "example1", "example2", "example3", "exams"
  std::string_view title;          ///< title of its section
  std::string_view label;          ///< \label of the paper's figure or table, or another source of its numbers
  std::string_view paper_reports;  ///< the paper's figures and claims
  /// Names in trainer/experiments/paper/, or FOLDER/NAME, or names of shipped experiments. Changes of an experiment may
  /// follow its name, each as " section.key=value".
  std::vector<std::string_view> experiments;
  double analysis_s = 1.0;  ///< approximate time at full size with 3 seeds, for the progress bar
  Section (*analyse)(const Workbench& bench);
  std::string_view logs = "";  ///< folder of its logs in --data; empty: simulated
};

std::span<const Item> items();

/// Returns the items for "all", for a group, or for one name, in the paper's order. Throws codegen::Error with the
/// nearest known name if the name is unknown.
std::vector<const Item*> select_items(const std::string& what);

}  // namespace nlo::trainer::reproduction
