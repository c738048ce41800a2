// SPDX-License-Identifier: MIT
// The program `nlo-reproduce`, which `nlo reproduce` starts: compares the paper's tables and figures with ours.
#include <fmt/core.h>
#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <string>

#include "trainer/app/commands/command.h"
#include "trainer/app/commands/output_directory.h"
#include "trainer/app/commands/program.h"
#include "trainer/app/jobs/run_jobs.h"
#include "trainer/app/terminal/status_line.h"
#include "trainer/base/printable.h"
#include "trainer/base/version.h"
#include "trainer/reproduce/page.h"
#include "trainer/reproduce/run.h"

namespace nlo::trainer {
namespace {

struct ReproduceArguments {
  std::string what, directory = "reproduction", data;
  bool quick = false;
  int seeds = 0;    ///< 0: 3, or 1 with --quick
  int threads = 0;  ///< 0: all cores; does not affect a result
};

void run_reproduce(const ReproduceArguments& arguments) {
  reproduction::Request request;
  request.what = arguments.what;
  request.directory = arguments.directory;
  request.data = arguments.data;
  request.threads = arguments.threads;
  request.quick = arguments.quick;
  if (request.quick) request.size = reproduction::kQuickSize;
  request.seeds = arguments.seeds > 0 ? arguments.seeds : (request.quick ? 1 : 3);
  request.stop = &stop_on_interrupt();
  (void)reproduction::select_items(request.what);  // an unknown name is an error of usage, not a failed run
  const OutputDirectory directory(request.directory);
  run_phase([&] {
    StatusLine line(stderr);
    JobsProgress progress(line);
    const reproduction::Result result = reproduction::reproduce(request, progress);
    line.finish();
    if (result.interrupted)
      throw RunFailure(result.trainings.interrupted_text(fmt::format(
          "nlo reproduce {}{}{}{} -o {}", request.what, request.quick ? " --quick" : "",
          request.data.empty() ? "" : " --data " + shell_word(request.data),
          arguments.seeds > 0 ? fmt::format(" --seeds {}", arguments.seeds) : "", shell_word(request.directory))));
    fmt::print("{}", reproduction::summary_text(result));
    fmt::print(
        "{} models trained, {} from the cache; \"!\" marks numbers more than {:.0f} % from the paper\npage     "
        "{}/reproduction.html\n",
        result.trainings.done, result.trainings.found, 100.0 * reproduction::kTolerance, request.directory);
  });
}

std::string names_of_items() {
  std::string names = "all, example1, example2, example3, exams";
  for (const reproduction::Item& item : reproduction::items()) names += fmt::format(",\n  {}", item.name);
  return names;
}

void add_options(CLI::App& app, ReproduceArguments& arguments) {
  app.add_option("WHAT", arguments.what, "all, an example, a table or a figure (--help lists them)")->required();
  app.add_flag("--quick", arguments.quick, "fewer steps, seeds and test trajectories, for a first impression");
  app.add_option("-o,--output", arguments.directory, "directory for reproduction.html, the CSV files and cache/")
      ->type_name("DIR")
      ->capture_default_str();
  app.add_option("--data", arguments.data,
                 "folder that contains the folders of logs; without it, items that need logs are left out")
      ->type_name("DIR");
  app.add_option("--seeds", arguments.seeds, "number of trained observers per experiment (default: 3; 1 with --quick)")
      ->check(CLI::Range(1, 100));
  app.add_option("--threads", arguments.threads, "number of threads; 0: all cores; does not affect the result")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.set_version_flag("-V,--version", std::string("nlo-reproduce ") + kVersion);
  app.footer(fmt::format("WHAT is one of:\n  {}\n", names_of_items()) +
             "Trained models are cached in DIR/cache. A second run with the same settings trains nothing, and an "
             "interrupted run continues.\nExamples:\n  nlo reproduce all\n  nlo reproduce table1 --quick -o /tmp/look");
}

}  // namespace
}  // namespace nlo::trainer

int main(int argc, char** argv) {
  using namespace nlo::trainer;  // NOLINT(google-build-using-namespace): a program
  return run_program(argc, argv, "nlo reproduce", kReproduceDescription, [](CLI::App& app, Action& action) {
    auto arguments = std::make_shared<ReproduceArguments>();
    add_options(app, *arguments);
    action = [arguments] { run_reproduce(*arguments); };
  });
}
