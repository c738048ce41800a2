// SPDX-License-Identifier: MIT
// nlo reproduce: the paper's tables and figures beside ours.
#include <fmt/core.h>
#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <string>

#include "trainer/commands/command.h"
#include "trainer/commands/directory_lock.h"
#include "trainer/commands/interrupt.h"
#include "trainer/commands/output_directory.h"
#include "trainer/reproduce/page.h"
#include "trainer/reproduce/run.h"
#include "trainer/terminal/status_line.h"

namespace nlo::trainer {
namespace {

using reproduction::Request;

struct ReproduceArguments {
  Request request;
  int seeds = 0;  ///< 0: 3, or 1 when quick
};

void run_reproduce(ReproduceArguments arguments) {
  Request& request = arguments.request;
  if (request.quick) request.size = reproduction::kQuickSize;
  request.seeds = arguments.seeds > 0 ? arguments.seeds : (request.quick ? 1 : 3);
  request.stop = &stop_on_interrupt();
  check_output_directory({request.directory, false, true}, "");
  (void)reproduction::select_items(request.what);  // an unknown name is wrong usage, not a failed run
  DirectoryLock lock;
  run_phase([&] {
    make_output_directory(request.directory);
    lock.take(request.directory);
    StatusLine line(stderr);
    reproduction::RunProgress progress(line);
    const reproduction::Result result = reproduction::reproduce(request, progress);
    line.finish();
    if (result.interrupted)
      throw RunFailure(fmt::format(
          "interrupted; finished models are kept in {0}/cache, and this goes on: nlo reproduce {1}{2}{3} -o {0}",
          request.directory, request.what, request.quick ? " --quick" : "",
          arguments.seeds > 0 ? fmt::format(" --seeds {}", arguments.seeds) : ""));
    fmt::print("{}", reproduction::summary_text(result));
    fmt::print(
        "{} models trained, {} from the cache; \"!\" is more than {:.0f} % from the paper\npage     "
        "{}/reproduction.html\n",
        result.trained, result.cached, 100.0 * reproduction::kTolerance, request.directory);
  });
}

}  // namespace

void add_reproduce(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<ReproduceArguments>();
  CLI::App* command = app.add_subcommand(
      "reproduce", "Make the paper's tables and figures, beside the paper's numbers, and a benchmark");
  command->add_option("WHAT", arguments->request.what, "all, an example, a table or a figure (listed below)")
      ->required();
  command->add_flag("--quick", arguments->request.quick, "a quick look: fewer steps, seeds and test trajectories");
  command
      ->add_option("-o,--output", arguments->request.directory,
                   "directory for reproduction.html, the CSV files and cache/")
      ->type_name("DIR")
      ->capture_default_str();
  command->add_option("--seeds", arguments->seeds, "trained observers per experiment (3; 1 with --quick)")
      ->check(CLI::Range(1, 100));
  command->add_option("--threads", arguments->request.threads, "0: all cores; does not change the result")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  std::string names = "all, example1, example2, example3";
  for (const reproduction::Item& item : reproduction::items()) names += fmt::format(",\n  {}", item.name);
  command->footer(
      fmt::format("WHAT is one of:\n  {}\n"
                  "Trained models are cached in DIR/cache by all that decides them: a second run trains nothing, "
                  "and an interrupted one goes on.\n"
                  "Examples:\n"
                  "  nlo reproduce all\n"
                  "  nlo reproduce table1 --quick -o /tmp/look",
                  names));
  command->callback([arguments, &action] { action = [arguments] { run_reproduce(*arguments); }; });
}

}  // namespace nlo::trainer
