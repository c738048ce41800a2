// SPDX-License-Identifier: MIT
// The trials of a search in words for people.
#pragma once

#include <string>
#include <vector>

#include "trainer/app/sweep/search_record.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {

struct SearchStory {
  std::string command, experiment;  ///< its name
  std::string held_out;             ///< logs that were taken from training to choose by; empty: none
  SearchRecord record;
};

/// Describes the settings that a candidate varies, for people.
std::string title_of(const Candidate& candidate);

/// The farther a candidate came the higher, then by error; the one chosen has a star.
Table search_table(const SearchStory& story);

/// Describes the choice beside the given experiment, then the search, in sentences.
std::vector<std::string> search_findings(const SearchStory& story);

/// For a terminal: the last rungs and the findings.
std::string search_text(const SearchStory& story);

}  // namespace nlo::trainer
