// SPDX-License-Identifier: MIT
// The ledger of results: every estimation figure that README and docs print, with the command that makes it. One file,
// docs/results.toml, read, checked and written back by the program `claims`.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace nlo::claims {

/// A training: `nlo train TRAIN --set SET... --seed N`, N = 1 to `seeds`.
struct Experiment {
  std::string id;
  std::string train;  ///< a shipped name, or a file of this repository: of a page its first block of TOML
  /// Folder of the logs, {data} in what its claims run: of this repository, or of the logs kept beside it; empty: none.
  std::string data;
  int seeds = 3;
  bool quick = false;                 ///< part of the quick run, with one seed: its claims that are not `slow`
  std::vector<std::string> set = {};  ///< section.key=value
  std::vector<std::string> flight_inputs = {};  ///< excitation of the plant in flight
  std::string flight_noise = "none";
  bool trains_on_data = true;  ///< false: it simulates, and the logs are for its tests alone
  bool watched = false;        ///< the model gets a monitor, too
};

/// One figure.
///   run     "evaluate ...", "bound ...": of `nlo evaluate MODEL ... --json`; {seeds} stands for the number of test
///   sets, {data} for
///           the folder of the logs
///           "flight": the exported header, compiled and flown over whole runs from their first sample
///           "reproduce ITEM": of `nlo reproduce`; one run over all seeds; "reproduce ITEM --data {data}" of logs
///           "identify NAME --data ...": of `nlo identify ... --json`, without an experiment; {data} is the folder of
///           all logs kept beside this repository, {source} the repository
///   metric  a JSON pointer; the name of a figure of the flight; or "row | column | reading" of the item's CSV
struct Claim {
  std::string id, experiment, run, metric;
  std::optional<double> tolerance;          ///< relative: how far the figure may move. Twice that in a quick run
  std::optional<double> at_least, at_most;  ///< or a limit, which a figure may not pass
  double value = 0.0, spread = 0.0;         ///< mean and population deviation over training seeds
  bool measured = false;
  bool slow = false;  ///< no part of the quick run
};

/// A table between `<!-- results ID -->` and `<!-- end of results -->` of a file; {claim} in a cell is its figure.
struct Table {
  std::string id, file;
  std::vector<std::string> heading;
  std::vector<std::vector<std::string>> rows;
};

struct Ledger {
  std::vector<Experiment> experiments;
  std::vector<Claim> claims;
  std::vector<Table> tables;
};

/// Throws std::runtime_error naming the entry that is wrong: an unknown experiment or claim, an id that is given twice,
/// neither tolerance nor limit.
Ledger read_ledger(const std::string& text, const std::string& file);

/// Writes the entries with their latest figures. Reading the text gives the same ledger.
std::string write_ledger(const Ledger& ledger);

/// Value and spread as nlo itself prints them: "0.0881 ± 0.00040".
std::string figure_text(const Claim& claim);

/// `page` with the tables of `file` as the ledger has them now. Throws std::runtime_error when the markers of one are
/// missing, or when the page has markers of a table that is not in the ledger.
std::string with_tables(const Ledger& ledger, const std::string& file, std::string page);

/// Empty when `measured` agrees with the claim; else what is wrong with it.
std::string disagreement(const Claim& claim, double measured, bool quick);

/// Mean and deviation of "table | row | column | reading" in an item's CSV.
std::pair<double, double> reproduced(const Claim& claim, const std::string& csv);

}  // namespace nlo::claims
