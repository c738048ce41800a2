// SPDX-License-Identifier: MIT
#include "trainer/commands/evaluate_options.h"

#include "trainer/commands/command.h"
#include "trainer/evaluation/evaluate.h"

namespace nlo::trainer {

std::vector<CLI::Option*> add_evaluate_options(CLI::App* command, EvaluateArguments& arguments) {
  command
      ->add_option("MODEL", arguments.models,
                   "model.json of nlo train; several of one experiment: means over training seeds")
      ->required();
  command
      ->add_option(
          "--noise", arguments.noise_words,
          "noise of the outputs: none, gaussian:SIGMA, uniform:HALF_WIDTH, student:SCALE:FREEDOM, and behind it "
          "+outliers:SHARE:AMPLITUDE, +bias:HALF_WIDTH, +common_bias:HALF_WIDTH, +clipped:LIMIT, +quantised:STEP, "
          "+delay:SAMPLES, +jitter:SHARE_OF_PERIOD, +missing:SHARE:SAMPLES_IN_A_ROW, likewise +stuck (its last value) "
          "and +dead (zero); or one for each output with commas "
          "between; may be repeated")
      ->allow_extra_args(false);
  command->add_option("--seed", arguments.test.seed, "seed of the initial states and the noise")
      ->check(check_seed)
      ->capture_default_str();
  std::vector<std::string> against = alternative_names();
  against.emplace_back(kTrueEkf);
  std::vector<CLI::Option*> for_plants;
  for_plants.push_back(command
                           ->add_option("--seeds", arguments.test.test_sets,
                                        "number of test sets, from --seed on: means and standard errors")
                           ->check(CLI::Range(1, 10000))
                           ->capture_default_str());
  for_plants.push_back(
      command
          ->add_option("--box-scale", arguments.common.box_scale,
                       "initial states from the training box times this (circle: its axes; list: about its mean)")
          ->check(check_scale)
          ->capture_default_str());
  for_plants.push_back(
      command->add_option("--trajectories", arguments.test.trajectories, "number of new trajectories in a test set")
          ->check(CLI::Range(1, 100000))
          ->capture_default_str());
  for_plants.push_back(
      command
          ->add_option("--input", arguments.common.inputs,
                       "excite the plant: u(t), as \"cos(12*t)\"; once for each of its inputs, in order; "
                       "else as the experiment's [excitation] says")
          ->allow_extra_args(false)
          ->type_name("EXPR"));
  for_plants.push_back(
      command
          ->add_option("--input-noise", arguments.input_noise,
                       "noise of the inputs that the observer reads, in the same words; the plant has none")
          ->allow_extra_args(false)
          ->type_name("NOISE"));
  for_plants.push_back(command
                           ->add_option("--set", arguments.common.changes,
                                        "test on a changed plant: plant.KEY=VALUE, simulation.KEY=VALUE, "
                                        "excitation.KEY=VALUE, feedback.KEY=VALUE; may be repeated")
                           ->allow_extra_args(false)
                           ->type_name("KEY=VALUE"));
  for_plants.push_back(
      command
          ->add_option("--against", arguments.test.against,
                       "ekf, ukf, mhe, high_gain (know the plant trained for), ekf_true (knows the changed plant), "
                       "static_ridge (knows no plant); constant and ridge are always shown")
          ->delimiter(',')
          ->allow_extra_args(false)
          ->check(CLI::IsMember(against)));
  command->add_option("--data", arguments.data, "CSV logs (or globs) to evaluate on, instead of the plant");
  command
      ->add_option("--columns", arguments.columns,
                   "roles of the logs' columns: [[log.columns]] as in an experiment; else those the model was "
                   "trained with, or headings that are the names of its outputs and states, and \"time\"")
      ->type_name("FILE.toml");
  command
      ->add_option("--from", arguments.from_s,
                   "with --data: start the observer this long after a log's first sample [s]; several: once for each")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("SECONDS");
  command
      ->add_option("--missing", arguments.missing,
                   "with --data: an output that fails at the first sample; may be repeated, or with commas between")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("OUTPUT");
  command
      ->add_option("--figure", arguments.files.figure,
                   "with --data: a picture of each log, estimate over truth, the error below, shaded outside of the "
                   "training domain; for several logs or starts FILE_1.svg, FILE_2.svg...")
      ->type_name("FILE.svg");
  command
      ->add_option("--estimates", arguments.files.estimates,
                   "with --data: inputs and estimates of the observer, sample by sample; several as above")
      ->type_name("FILE.csv");
  command->add_option("--threads", arguments.test.threads, "0: all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command->add_flag("--json", arguments.json, "one JSON array instead of tables: an object for each noise");
  command->footer(
      "Beside the observer stand a constant and a ridge regression on the observer's own features; on logs the sensor\n"
      "itself, polynomials and a ridge regression on products of readings, too. These are fitted on the training logs\n"
      "where they lie in the same folder, else on the very logs of the test, in hindsight.\n"
      "Examples:\n"
      "  nlo evaluate runs/van_der_pol/model.json --noise none --noise gaussian:0.5 --against ekf\n"
      "  nlo evaluate runs/s1/model.json runs/s2/model.json runs/s3/model.json --seeds 20 --noise gaussian:0.5\n"
      "  nlo evaluate runs/van_der_pol/model.json --set plant.parameters.mu=1.2 --against ekf,ekf_true\n"
      "  nlo evaluate runs/van_der_pol/model.json --noise uniform:3 --seed 7 --box-scale 2 --json\n"
      "  nlo evaluate runs/van_der_pol/model.json --input \"0.5*sin(2*t)\" --against ekf\n"
      "  nlo evaluate runs/qube/model.json --data logs/run8.csv logs/run9.csv\n"
      "  nlo evaluate runs/battery/model.json --data logs/cycle.csv --from 0,600,3000\n"
      "  nlo evaluate runs/car/model.json --data logs/run8.csv --missing wheel_speed\n"
      "  nlo evaluate runs/car/model.json --data logs/run8.csv --figure run8.svg --estimates run8_estimates.csv\n"
      "  nlo evaluate runs/van_der_pol/model.json --data bench.csv --columns bench.toml");
  return for_plants;
}

}  // namespace nlo::trainer
