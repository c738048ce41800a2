// SPDX-License-Identifier: MIT
// The program `nlo`: results on stdout, progress and errors on stderr. Exit codes: see app/commands/command.h.
#include <string>

#include "trainer/app/commands/command.h"
#include "trainer/app/commands/program.h"
#include "trainer/base/version.h"

int main(int argc, char** argv) {
  return nlo::trainer::run_program(
      argc, argv, "nlo",
      "Neural Luenberger observers: train one from a plant or from logs, evaluate it, export it for firmware.",
      [argc, argv](CLI::App& app, nlo::trainer::Action& action) {
        app.set_version_flag("-V,--version", std::string("nlo ") + nlo::trainer::kVersion);
        app.require_subcommand(1);
        app.footer(
            "Start with:\n"
            "  nlo train van_der_pol && nlo evaluate runs/van_der_pol/model.json --noise gaussian:0.5\n"
            "  nlo export runs/van_der_pol/model.json -o van_der_pol.h\n"
            "Exit codes: 0 done, 1 the run failed, 2 wrong usage, config or input.");
        nlo::trainer::add_new(app, action);
        nlo::trainer::add_train(app, action);
        nlo::trainer::add_evaluate(app, action);
        nlo::trainer::add_compare(app, action);
        nlo::trainer::add_crossvalidate(app, action);
        nlo::trainer::add_identify(app, action);
        nlo::trainer::add_certify(app, argc, argv);
        nlo::trainer::add_monitor(app, action);
        nlo::trainer::add_export(app, action);
        nlo::trainer::add_replay(app, action);
        nlo::trainer::add_report(app, action);
        nlo::trainer::add_reproduce(app, argc, argv);
        nlo::trainer::add_simulate(app, action);
        nlo::trainer::add_sweep(app, action);
      });
}
