// SPDX-License-Identifier: MIT
// The ledger of results: each estimation error that README and docs print, with the command that produces it. The
// program `claims` reads, checks and writes this file, docs/results.toml.
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
  std::string train;  ///< a shipped name, a file of this repository, or a page, whose first experiment is used
  /// Folder of the logs, {data} in the commands of its claims: in this repository, or beside it; empty: none.
  std::string data;
  int seeds = 3;
  bool quick = false;  ///< whether the quick run includes it, with one seed and without its `slow` claims
  std::vector<std::string> set = {};            ///< section.key=value
  std::vector<std::string> flight_inputs = {};  ///< excitation of the plant in flight
  std::string flight_noise = "none";
  bool trains_on_data = true;  ///< false: it trains on simulated runs, and the logs are only for its tests
  bool watched = false;        ///< whether the model also gets a monitor
};

/// A figure that the docs print.
///   run     what measures the figure; {data} stands for the folder of the logs, {seeds} for the number of test sets:
///           "evaluate ...", "bound ...": `nlo evaluate MODEL ... --json`
///           "flight": the exported header, compiled and flown over whole runs from their first sample
///           "reproduce ITEM", "reproduce ITEM --data {data}": one run of `nlo reproduce` over all seeds
///           "identify NAME --data ...": `nlo identify ... --json`, without an experiment. Here {data} stands for the
///           folder of all logs beside this repository, and {source} for the repository
///   metric  a JSON pointer; the name of a figure of the flight; or "row | column | reading" of the item's CSV
struct Claim {
  std::string id, experiment, run, metric;
  std::optional<double> tolerance;          ///< relative change that the figure may have; twice that in a quick run
  std::optional<double> at_least, at_most;  ///< or a limit of the figure
  double value = 0.0, spread = 0.0;         ///< mean and population deviation over training seeds
  bool measured = false;
  bool slow = false;  ///< whether the quick run leaves it out
};

/// A table between `<!-- results ID -->` and `<!-- end of results -->` in a file; {claim} in a cell stands for its
/// figure.
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

/// Parses a ledger. Throws std::runtime_error that names the wrong entry: an unknown experiment or claim, an id given
/// twice, neither tolerance nor limit.
Ledger read_ledger(const std::string& text, const std::string& file);

/// Writes the entries with their latest figures. Reading the text gives the same ledger.
std::string write_ledger(const Ledger& ledger);

/// Returns value and spread as nlo prints them: "0.0881 ± 0.00040".
std::string figure_text(const Claim& claim);

/// Returns `page` with the current tables of `file`. Throws std::runtime_error if the markers of a table are missing,
/// or if the page has markers of a table that is not in the ledger.
std::string with_tables(const Ledger& ledger, const std::string& file, std::string page);

/// Returns an empty text if `measured` agrees with the claim, otherwise the difference.
std::string disagreement(const Claim& claim, double measured, bool quick);

/// Returns mean and deviation of "table | row | column | reading" in the CSV of an item.
std::pair<double, double> reproduced(const Claim& claim, const std::string& csv);

}  // namespace nlo::claims
