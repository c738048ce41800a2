// SPDX-License-Identifier: MIT
// Reproduces the ledger of results (docs/results.toml): trains, evaluates, exports and flies as a user does, and
// compares each figure with the published one.
#include <fmt/core.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "codegen/base/file.h"
#include "tests/claims/flight.h"
#include "tests/claims/ledger.h"
#include "trainer/app/jobs/run_jobs.h"
#include "trainer/base/printable.h"

namespace {

using namespace nlo::claims;  // NOLINT(google-build-using-namespace): a program of this folder alone
namespace fs = std::filesystem;
using nlo::trainer::Job;
using nlo::trainer::JobEnd;
using nlo::trainer::shell_word;

struct Options {
  bool quick = false, update = false, tables = false, resume = false;
  std::string ledger = NLO_SOURCE_DIR "/docs/results.toml", data = NLO_SHARED_DATA_DIR, only;
  std::string command;  ///< command that continues after an interruption
  Tools tools{NLO_PROGRAM, NLO_COMPILER, NLO_SOURCE_DIR "/runtime/include", NLO_SOURCE_DIR, "build/claims"};
};

constexpr int kTestSets = 20, kQuickTestSets = 3;

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
  return text;
}

/// Returns the folder of an experiment's logs; empty if they are missing.
std::string data_folder(const Experiment& experiment, const Options& options) {
  for (const std::string& root : {options.tools.source, options.data})
    if (fs::is_directory(root + "/" + experiment.data)) return root + "/" + experiment.data;
  return "";
}

/// Returns a shipped name unchanged, a file by its path, and the TOML of a page as a file in `directory`.
std::string train_argument(const Experiment& experiment, const Options& options, const std::string& directory) {
  const std::string file = options.tools.source + "/" + experiment.train;
  if (!fs::exists(file)) return experiment.train;
  if (!file.ends_with(".md")) return file;
  const std::string page = nlo::codegen::read_file(file), fence = "```", begin = fence + "toml\n";
  const std::size_t found = page.find(begin + "name = "), from = found + begin.size();
  const std::size_t to = found == std::string::npos ? found : page.find(fence, from);
  if (to == std::string::npos) throw std::runtime_error(file + ": has no block of TOML that begins with a name");
  const std::string experiment_file = directory + "/experiment.toml";
  nlo::codegen::write_file_atomically(experiment_file, page.substr(from, to - from));
  return experiment_file;
}

/// The figures of one training seed, by "run\nmetric".
class Run {
 public:
  Run(const Experiment& experiment, int seed, const std::string& data, const Options& options)
      : experiment_(experiment),
        options_(options),
        data_(data),
        directory_(fmt::format("{}/{}_{}", options.tools.work, experiment.id, seed)) {
    if (!options.resume) fs::remove_all(directory_);
    fs::create_directories(directory_);
    std::string command =
        fmt::format("{} train {} -o {} --seed {} --threads 1 -q", shell_word(options.tools.nlo),
                    shell_word(train_argument(experiment, options, directory_)), shell_word(directory_), seed);
    for (const std::string& change : experiment.set) command += " --set " + shell_word(change);
    const std::string logs = !data.empty() && experiment.trains_on_data ? " --data " + shell_word(data) : "";
    fmt::print(stderr, "{}: training seed {}\n", experiment.id, seed);
    (void)output_of(command + logs + (options.resume ? " --resume" : ""), directory_ + "/train.log");
    if (experiment.watched)
      (void)output_of(fmt::format("{} monitor {}{} --accept-undetected", shell_word(options.tools.nlo),
                                  shell_word(directory_ + "/model.json"), logs),
                      directory_ + "/monitor.log");
  }

  double figure(const Claim& claim) {
    if (claim.run == "flight") {
      if (flight_.empty()) flight_ = fly(experiment_, directory_, data_, options_.tools);
      const auto found = flight_.find(claim.metric);
      if (found == flight_.end()) throw std::runtime_error(claim.id + ": a flight has no figure " + claim.metric);
      return found->second;
    }
    const nlohmann::json& said = evaluated(claim.run);
    const nlohmann::json::json_pointer at(claim.metric);
    if (!said.contains(at) || !said.at(at).is_number())
      throw std::runtime_error(fmt::format("{}: nlo {} has no number at {}", claim.id, claim.run, claim.metric));
    return said.at(at).get<double>();
  }

 private:
  const nlohmann::json& evaluated(const std::string& run) {
    const auto found = said_.find(run);
    if (found != said_.end()) return found->second;
    const std::string sets = std::to_string(options_.quick ? kQuickTestSets : kTestSets);
    const std::string verb = run.substr(0, run.find(' '));
    const std::string arguments = replaced(replaced(run.substr(run.find(' ') + 1), "{seeds}", sets), "{data}", data_);
    const std::string command = fmt::format("{} {} {} {} --threads 1 --json", shell_word(options_.tools.nlo), verb,
                                            shell_word(directory_ + "/model.json"), arguments);
    const std::string log = fmt::format("{}/{}_{}.log", directory_, verb, said_.size() + 1), made_by = log + ".command";
    const bool known = options_.resume && fs::exists(made_by) && nlo::codegen::read_file(made_by) == command;
    const std::string text = known ? nlo::codegen::read_file(log + ".out") : output_of(command, log);
    nlo::codegen::write_file_atomically(made_by, command);
    return said_.emplace(run, nlohmann::json::parse(text)).first->second;
  }

  const Experiment& experiment_;
  const Options& options_;
  std::string data_, directory_;
  std::map<std::string, double> flight_;
  std::map<std::string, nlohmann::json> said_;
};

class Claims {
 public:
  explicit Claims(Options options)
      : options_(std::move(options)), ledger_(read_ledger(nlo::codegen::read_file(options_.ledger), options_.ledger)) {
    fs::create_directories(options_.tools.work);
    options_.tools.work = fs::absolute(options_.tools.work).string();
  }

  int run() {
    if (!options_.tables) {
      // Each experiment uses one thread: several experiments in parallel use the cores better than one on all threads.
      std::vector<Job> jobs;
      for (const Experiment& experiment : ledger_.experiments)
        if (const std::vector<Claim*> claims = claims_of(experiment); !claims.empty())
          jobs.push_back({experiment.id, 1.0, [=, this, &experiment](const nlo::trainer::JobContext& context) {
                            return trained(experiment, claims, *context.stop);
                          }});
      const nlo::trainer::JobsResult result =
          run_jobs(jobs, {.keep_going = true, .stop = &nlo::trainer::stop_on_interrupt()});
      if (result.left > 0) throw std::runtime_error(result.interrupted_text(options_.command));
      result.check();
      if (!options_.quick) reproductions();
      identifications();
    }
    if (options_.update || options_.tables) write();
    if (!options_.tables)
      fmt::print("{} figures of {} agree with the ledger{}\n", agreed_, agreed_ + failed_,
                 skipped_ == 0 ? "" : fmt::format(", {} were left out", skipped_));
    return failed_ > 0 && !options_.update ? 1 : 0;
  }

 private:
  bool wanted(const std::string& id) const { return id.starts_with(options_.only); }

  /// Returns the claims to reproduce.
  std::vector<Claim*> claims_of(const Experiment& experiment) {
    std::vector<Claim*> claims;
    if (options_.quick && !experiment.quick) return claims;
    for (Claim& claim : ledger_.claims)
      if (claim.experiment == experiment.id && wanted(claim.id) && !(options_.quick && claim.slow))
        claims.push_back(&claim);
    return claims;
  }

  /// Returns whether the logs of the claim are missing.
  bool left_out(const Claim& claim) {
    if (claim.run.find("{data}") == std::string::npos || fs::is_directory(options_.data)) return false;
    fmt::print("{}: left out, its logs are not in {}\n", claim.id, options_.data);
    ++skipped_;
    return true;
  }

  JobEnd trained(const Experiment& experiment, const std::vector<Claim*>& claims, const std::atomic<bool>& stop) {
    const std::string data = experiment.data.empty() ? "" : data_folder(experiment, options_);
    if (!experiment.data.empty() && data.empty()) {
      const std::lock_guard lock(mutex_);
      fmt::print("{}: left out, its logs are not in {}/{}\n", experiment.id, options_.data, experiment.data);
      skipped_ += static_cast<int>(claims.size());
      return JobEnd::kFound;
    }
    const auto start = std::chrono::steady_clock::now();
    const int seeds = options_.quick ? 1 : experiment.seeds;
    std::vector<std::vector<double>> values(claims.size());
    for (int seed = 1; seed <= seeds; ++seed) {
      if (stop.load()) return JobEnd::kStopped;
      Run run(experiment, seed, data, options_);
      for (std::size_t i = 0; i < claims.size(); ++i) values[i].push_back(run.figure(*claims[i]));
    }
    const std::lock_guard lock(mutex_);
    fmt::print("{}: {} {}, {:.0f} s\n", experiment.id, seeds, seeds == 1 ? "training seed" : "training seeds",
               std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    for (std::size_t i = 0; i < claims.size(); ++i) {
      double mean = 0.0, squares = 0.0;
      for (const double value : values[i]) mean += value / static_cast<double>(seeds);
      for (const double value : values[i]) squares += (value - mean) * (value - mean) / static_cast<double>(seeds);
      settle(*claims[i], mean, std::sqrt(squares));
    }
    return JobEnd::kDone;
  }

  void reproductions() {
    std::map<std::string, std::string> csv;
    for (Claim& claim : ledger_.claims) {
      if (!claim.run.starts_with("reproduce ") || !wanted(claim.id)) continue;
      if (left_out(claim)) continue;
      const std::string arguments = replaced(claim.run, "{data}", shell_word(options_.data));
      const std::string item =
          arguments.substr(claim.run.find(' ') + 1, arguments.find(" --") - claim.run.find(' ') - 1);
      if (!csv.contains(item)) {
        const std::string folder = options_.tools.work + "/reproduce";
        (void)output_of(fmt::format("{} {} -o {}", shell_word(options_.tools.nlo), arguments, shell_word(folder)),
                        options_.tools.work + "/reproduce.log");
        const std::string numbers = fmt::format("{}/{}-numbers.csv", folder, item);  // beside the data of figures
        csv[item] = nlo::codegen::read_file(fs::exists(numbers) ? numbers : fmt::format("{}/{}.csv", folder, item));
      }
      const auto [mean, deviation] = reproduced(claim, csv[item]);
      settle(claim, mean, deviation);
    }
  }

  /// Identifications have no random numbers, so one run of each command is enough.
  void identifications() {
    std::map<std::string, nlohmann::json> said;
    for (Claim& claim : ledger_.claims) {
      if (!claim.run.starts_with("identify ") || !wanted(claim.id) || (options_.quick && claim.slow)) continue;
      if (left_out(claim)) continue;
      if (!said.contains(claim.run)) {
        const std::string folder = fmt::format("{}/identify_{}", options_.tools.work, said.size() + 1);
        const std::string arguments =
            replaced(replaced(claim.run, "{data}", options_.data), "{source}", options_.tools.source);
        fs::create_directories(folder);
        said[claim.run] = nlohmann::json::parse(output_of(
            fmt::format("{} {} --json --force -o {}", shell_word(options_.tools.nlo), arguments, shell_word(folder)),
            folder + "/identify.log"));
      }
      const nlohmann::json::json_pointer at(claim.metric);
      const nlohmann::json& all = said[claim.run];
      if (!all.contains(at) || !all.at(at).is_number())
        throw std::runtime_error(fmt::format("{}: nlo {} has no number at {}", claim.id, claim.run, claim.metric));
      settle(claim, all.at(at).get<double>(), 0.0);
    }
  }

  void settle(Claim& claim, double value, double spread) {
    const std::string wrong = disagreement(claim, value, options_.quick);
    fmt::print("  {:<44} {:<10.4g} {}\n", claim.id, value, wrong.empty() ? "" : "MOVED: " + wrong);
    std::fflush(stdout);
    (wrong.empty() ? agreed_ : failed_) += 1;
    if (!options_.update || options_.quick) return;
    claim.value = value;
    claim.spread = spread;
    claim.measured = true;
  }

  void write() {
    nlo::codegen::write_file_atomically(options_.ledger, write_ledger(ledger_));
    std::set<std::string> files;
    for (const Table& table : ledger_.tables) files.insert(table.file);
    for (const std::string& file : files) {
      const std::string path = options_.tools.source + "/" + file;
      nlo::codegen::write_file_atomically(path, with_tables(ledger_, file, nlo::codegen::read_file(path)));
    }
  }

  Options options_;
  Ledger ledger_;
  std::mutex mutex_;
  int agreed_ = 0, failed_ = 0, skipped_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Runs the ledger of results, docs/results.toml, and fails when a figure has moved past its tolerance.");
  app.add_flag("--quick", options.quick, "the experiments marked quick, one training seed, 3 test sets for 20");
  app.add_flag("--update", options.update, "write the figures into the ledger and into the tables of the pages");
  app.add_flag("--tables", options.tables,
               "run nothing: write the ledger in its form, and the tables of the pages from it");
  app.add_flag("--resume", options.resume, "go on with the models and evaluations that an earlier run left in --work");
  app.add_option("--only", options.only, "claims whose id begins so");
  app.add_option("--ledger", options.ledger, "another ledger")->capture_default_str();
  app.add_option("--data", options.data, "folder of the rigs' logs")->capture_default_str();
  app.add_option("--work", options.tools.work, "where models and flights go")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  for (int i = 0; i < argc; ++i) options.command += shell_word(argv[i]) + " ";
  options.command += options.resume ? "" : "--resume";
  if (options.quick && options.update) {
    fmt::print(stderr, "claims: --update takes the full run; leave out --quick\n");
    return 2;
  }
  try {
    Claims claims(options);
    return claims.run();
  } catch (const std::exception& error) {
    fmt::print(stderr, "claims: error: {}\n", error.what());
    return 1;
  }
}
