// SPDX-License-Identifier: MIT
// The trials of a search in words for readers.
#pragma once

#include <string>
#include <vector>

#include "trainer/app/sweep/search_record.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {

struct SearchStory {
  std::string command, experiment;  ///< its name
  std::string held_out;             ///< logs that were held out of training for the choice; empty: none
  SearchRecord record;
};

/// Describes the settings that a candidate varies for readers.
std::string title_of(const Candidate& candidate);

/// Returns a table, sorted by the last rung of a candidate, then by error. The chosen one has a star.
Table search_table(const SearchStory& story);

/// Returns sentences that compare the choice with the given experiment and describe the search.
std::vector<std::string> search_findings(const SearchStory& story);

/// Returns the last rungs and the findings for a terminal.
std::string search_text(const SearchStory& story);

}  // namespace nlo::trainer
