// SPDX-License-Identifier: MIT
#include "trainer/commands/reproduce_options.h"

#include "trainer/base/version.h"

namespace nlo::trainer {

void add_reproduce_options(CLI::App& app, ReproduceArguments& arguments, const std::string& about_what) {
  app.add_option("WHAT", arguments.what, "all, an example, a table or a figure (--help lists them)")->required();
  app.add_flag("--quick", arguments.quick, "a quick look: fewer steps, seeds and test trajectories");
  app.add_option("-o,--output", arguments.directory, "directory for reproduction.html, the CSV files and cache/")
      ->type_name("DIR")
      ->capture_default_str();
  app.add_option("--data", arguments.data, "folder of the folders of logs: items of logs are left out without it")
      ->type_name("DIR");
  app.add_option("--seeds", arguments.seeds, "trained observers per experiment (3; 1 with --quick)")
      ->check(CLI::Range(1, 100));
  app.add_option("--threads", arguments.threads, "0: all cores; does not change the result")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.set_version_flag("-V,--version", std::string("nlo-reproduce ") + kVersion);
  app.footer(about_what +
             "Trained models are cached in DIR/cache by all that decides them: a second run trains nothing, and an "
             "interrupted one goes on.\n"
             "Examples:\n"
             "  nlo reproduce all\n"
             "  nlo reproduce table1 --quick -o /tmp/look");
}

}  // namespace nlo::trainer
