// SPDX-License-Identifier: MIT
#include "trainer/app/commands/train_auto.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <utility>

#include "codegen/base/file.h"
#include "trainer/app/commands/command.h"
#include "trainer/app/commands/run_folder.h"
#include "trainer/app/report/pages.h"
#include "trainer/app/sweep/search_text.h"
#include "trainer/base/printable.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/learn/training/checkpoint.h"

namespace nlo::trainer {
namespace {

std::string command_line(const TrainArguments& arguments, const SearchBudget& budget, const RunFolder& folder) {
  std::string text = fmt::format("nlo train {} --auto --minutes {:g}",
                                 command_words(arguments.experiment, arguments.data), budget.minutes);
  if (budget.multiply_adds > 0) text += fmt::format(" --max-multiply-adds {}", budget.multiply_adds);
  if (budget.flash_bytes > 0) text += fmt::format(" --max-flash-bytes {}", budget.flash_bytes);
  return text + " -o " + shell_word(folder.path());
}

/// Returns the experiment from which the search starts, complete and with its delays as numbers.
Experiment completed(const DraftExperiment& draft, const TrainArguments& arguments) {
  PreparedRun run{draft.experiment, {}, false};
  if (!draft.complete) {
    run = read_logs(draft, arguments.data, arguments.quiet);
    simulate_and_derive(draft, arguments.data, arguments.quiet, run);
  } else if (draft.experiment.log) {
    find_delays(run.experiment, arguments.data, arguments.quiet);
  }
  return run.experiment;
}

/// Returns the experiment that the search found, with the user's split of the logs.
Experiment found_experiment(const SearchRecord& record, const Experiment& given) {
  const Trial& chosen = record.chosen();
  Experiment found = parse_experiment(record.candidates[chosen.candidate].experiment, "auto.json");
  set_steps(found, chosen.steps);
  if (found.log) {
    found.log->train_files = given.log->train_files;
    found.log->validation_files = given.log->validation_files;
    found.log->test_files = given.log->test_files;
  }
  found.source_text = format_experiment(found);
  return found;
}

}  // namespace

void run_train_auto(const TrainArguments& given, const SearchBudget& budget) {
  TrainArguments arguments = given;
  const DraftExperiment draft = draft_to_train(arguments);
  const RunFolder folder(arguments.output.empty() ? "runs/" + draft.experiment.name + "_auto" : arguments.output,
                         draft.experiment, arguments.force);
  const Experiment experiment = completed(draft, arguments);
  const SearchTask task = search_task(experiment, arguments.data);
  const std::string command = command_line(arguments, budget, folder);
  SearchRecord record;
  try {
    record = run_search(task, budget, folder.path(), arguments.resume, arguments.quiet);
  } catch (const TooLittleTime&) {
    throw;
  } catch (const RunFailure& failure) {
    throw RunFailure(fmt::format("{}; to continue: {} --resume", failure.what(), command));
  }
  run_phase([&] {
    const SearchStory story{command, experiment.name, task.held_out, std::move(record)};
    fmt::print("{}", printable(search_text(story)));
    codegen::write_file_atomically(folder.path() + "/auto.html", search_page(story));
    codegen::write_file_atomically(
        folder.path() + "/experiment.toml",
        fmt::format("# Found by: {}\n{}", command, found_experiment(story.record, experiment).source_text));
    fmt::print("tried    {0}/auto.html\nfound    {0}/experiment.toml, which is trained now\n", folder.path());
  });
  arguments.experiment = {folder.path() + "/experiment.toml", {}, {}, arguments.experiment.threads};
  arguments.resume = has_checkpoint(folder.path());  // true if a training was interrupted
  carry_out(draft_to_train(arguments), arguments, folder);
}

}  // namespace nlo::trainer
