// SPDX-License-Identifier: MIT
// The columns of a comparison: what each is made of, what it is called, and what a step of it costs.
#pragma once

#include <string>
#include <vector>

#include "trainer/compare/compare_study.h"
#include "trainer/compare/filter_table.h"

namespace nlo::trainer {

/// What one column is made of: an observer, a filter, one of simple_names(), or, of nothing, the floor.
struct MadeOf {
  const ComparedModel* model = nullptr;
  const FilterRow* filter = nullptr;
  bool tuned = false;
  std::string simple = {};
};

struct ComparedColumn {
  CompareColumn column;
  MadeOf made_of;
};

/// The observers, then of what `test` wants: filters as shipped and tuned, what knows no plant, the floor.
///   nominal           the experiment with its nominal parameters
///   joint_parameters  that filters of state and parameters estimate
std::vector<ComparedColumn> compared_columns(const std::vector<ComparedModel>& models, const Experiment& nominal,
                                             const std::vector<std::string>& joint_parameters, const CompareTest& test);

}  // namespace nlo::trainer
