// SPDX-License-Identifier: MIT
// Each row makes one change to the small experiment. The message must name the line, the fault and the remedy.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/experiments/experiment_text.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST(ConfigErrors, ListKnownNamesForUnknownOnes) {
  expect_rows(
      kPlantExperiment,
      {
          {"eigenvalues =", "eigen_values =", "e.toml:14",
           "unknown key \"eigen_values\" in [observer]; did you mean \"eigenvalues\"?"},
          {"steps = 10", "hold = \"rk4\"", "e.toml:19", "unknown key \"hold\" in [training]; it belongs in [observer]"},
          {"[observer]", "[observr]", "e.toml:13",
           "unknown key \"observr\" in the experiment; did you mean \"observer\"?"},
          {"steps = 10", "zzz = 10", "e.toml:19", "there are: mode, steps"},
          {"\"first_order\"", "\"firstorder\"", "e.toml:16", "use \"first_order\"? There are \"zero_order\""},
          {"\"van_der_pol\"", "\"vanderpol\"", "e.toml:4", "did you mean \"van_der_pol\"?"},
          {"mu = 1.5", "nu = 1.5", "e.toml:5", "has no parameter \"nu\"; did you mean \"mu\"?"},
          {"gaussian:0.5", "gausian:0.5", "e.toml:20", "noise \"gausian:0.5\" is of an unknown kind; write none"},
      });
}

TEST(ConfigErrors, NameTheExpectedType) {
  expect_rows(
      kPlantExperiment,
      {
          {"steps = 10", "steps = 10.5", "e.toml:19", "[training] steps is 10.5; it must be an integer"},
          {"steps = 10", "steps = \"many\"", "e.toml:19", "[training] steps is \"many\"; it must be an integer"},
          {"horizon_s = 10.0", "horizon_s = true", "e.toml:8", "horizon_s is true; it must be a number"},
          {"[-1.0, -2.0]", "-1.0", "e.toml:14", "eigenvalues is -1; it must be a list"},
          {"[-1.0, -2.0]", "[-1.0, \"x\"]", "e.toml:14", "eigenvalues[1] is \"x\"; it must be a number < 0"},
          {"[[-0.5, 1.0]]", "[[-0.5]]", "e.toml:15", "pairs[0] is a list; it must be [re, im]"},
          {"\"first_order\"", "1", "e.toml:16", "hold is 1; it must be a text"},
          {"{ mu = 1.5 }", "[1.5]", "e.toml:5", "parameters is a list; it must be a table"},
          {"\"gaussian:0.5\"", "0.5", "e.toml:20", "noise is 0.5; it must be \"none\""},
          {"[plant]", "observer.hold.x = 1\n[plant]", "e.toml:14", "already exists"},
          {"name = \"small\"", "name = \"small\"\nseed = 1979-05-27", "e.toml:2", "seed is a date or time"},
      });
}

TEST(ConfigErrors, NameTheAllowedRange) {
  expect_rows(
      kPlantExperiment,
      {
          {"trajectories = 4", "trajectories = 0", "e.toml:9", "trajectories is 0; it must be an integer from 1"},
          {"steps = 10", "learning_rate = 0", "e.toml:19", "learning_rate is 0; it must be a finite number > 0"},
          {"steps = 10", "steps = 0", "e.toml:19", "steps = 0 leaves the network untrained"},
          {"steps = 10", "learning_rate = nan", "e.toml:19", "learning_rate is nan"},
          {"steps = 10", "learning_rate = 1e999", "e.toml:19", "learning_rate"},
          {"steps = 10", "steps = 99999999999999999999", "e.toml:19", "too many digits"},
          {"steps = 10", "ema = 1.0", "e.toml:19", "ema is 1; it must be a finite number from 0 to 1 (excluded)"},
          {"steps = 10", "early_share = 0.3", "e.toml:19", "early_share needs the time early_s"},
          {"[training]", "[inverse_map]\nhidden = []\nerror = true\n[training]", "e.toml:20",
           "error reads the last hidden layer of T*, but hidden = [] means that there is none"},
          {"[training]", "[inverse_map]\nfallback = true\n[training]", "e.toml:19",
           "fallback is selected on left-out logs, but there are none"},
          {"steps = 10", "segment_s = 20.0", "e.toml:19", "segment_s is 20; it must be at most horizon_s, 10"},
          {"-2.0]", "2.0]", "e.toml:14", "eigenvalues[1] is 2; it must be a finite number < 0"},
          {"[-0.5, 1.0]", "[0.5, 1.0]", "e.toml:15", "pairs[0] has the real part 0.5; it must be < 0"},
          {"[-0.5, 1.0]", "[-0.5, 0.0]", "e.toml:15", "pairs[0] has the imaginary part 0; it must be > 0"},
          {"[-1, -1]", "[-1, 2]", "e.toml:11", "initial_high[1] is 1; it must not be below initial_low[1], 2"},
          {"[-1, -1]", "[-1]", "e.toml:10", "initial_low has 1 numbers; the plant has 2 states"},
          {"initial_low = [-1, -1]\n", "", "e.toml:7", "initial_low is missing"},
          {"horizon_s = 10.0", "horizon_s = 0.01", "e.toml:8", "the horizon must be longer than the sample period"},
          {"horizon_s = 10.0", "horizon_s = 1e9", "e.toml:8", "do not fit into memory"},
          {"gaussian:0.5", "gaussian:-1", "e.toml:20", "negative scale"},
          {"gaussian:0.5", "none\"\nnoise_level_max = 2 #", "e.toml:21", "noise_level_max scales the noise"},
          {"name = \"small\"", "name = \"two words\"", "e.toml:1", "it must be an identifier"},
          {"name = \"small\"", "name = \"class\"", "e.toml:1", "no C++ word"},
          {"name = \"small\"\n", "", "e.toml", "no name"},
          {"name = \"small\"", "name = \"small\"\nseed = -1", "e.toml:2", "seed is -1; it must be an integer >= 0"},
      });
}

TEST(ConfigErrors, NameTransientsThatDoNotFit) {
  // Eigenvalues -1, -2 and a pair with real part -0.5: with k = 5 the transient lasts 10 s, which is the whole horizon.
  expect_rows(
      kPlantExperiment,
      {
          {"steps = 10", "transient = \"dropped\"", "e.toml:19", "transient is \"dropped\""},
          {"steps = 10", "transient_factor = 0", "e.toml:19", "transient_factor is 0; it must be a finite number > 0"},
          {"steps = 10", "transient = \"drop\"", "e.toml:19", "leaves no sample of the horizon of 10 s"},
          {"steps = 10", "transient = \"backward\"\ntransient_factor = 1e6", "e.toml:19",
           "the transient lasts 2e+06 s"},
          {"steps = 10", "transient = \"backward\"\nsegment_s = 2.0", "e.toml:20", "set segment_s = 0"},
          {"steps = 10", "transient = \"backward\"\nearly_s = 2.0\nearly_share = 0.3", "e.toml:21",
           "early_share draws samples"},
      });
  const std::string luenberger =
      with(kPlantExperiment, "eigenvalues = [-1.0, -2.0]\npairs = [[-0.5, 1.0]]\nhold = \"first_order\"",
           "structure = \"luenberger\"\nstate_matrix = [[0, 1], [-1, 0]]\noutput_matrix = [[1, 0]]\ngain = [[3], [1]]");
  EXPECT_EQ(error_of(luenberger), "no error");
  expect_rows(luenberger, {{"steps = 10", "transient = \"drop\"", "e.toml:20", "this observer has none"}});
  expect_rows(kLogExperiment, {{"[observer]", "[training]\ntransient = \"backward\"\n[observer]", "e.toml:22",
                                "but this experiment has logs; use \"drop\""}});
  EXPECT_EQ(error_of(with(kPlantExperiment, "steps = 10", "transient = \"drop\"\ntransient_factor = 4.9")), "no error");
  EXPECT_EQ(error_of(with(kPlantExperiment, "steps = 10", "transient = \"backward\"")), "no error");
  EXPECT_EQ(error_of(with(kLogExperiment, "[observer]", "[training]\ntransient = \"drop\"\n[observer]")), "no error");
}

TEST(ConfigErrors, NameWrongWindowsOfTheEvaluation) {
  const auto windows = [](const std::string& list) { return "steps = 10\n[evaluation]\nwindows = " + list + "\n#"; };
  const std::string at = "e.toml:21";
  expect_rows(
      with(kPlantExperiment, "noise = \"gaussian:0.5\"\n", ""),
      {
          {"steps = 10", windows("[{ name = \"all\" }]"), at, "window \"all\" is the name of the whole run"},
          {"steps = 10", windows("[{ name = \"a\" }, { name = \"a\", to_s = 2 }]"), at, "\"a\" is listed twice"},
          {"steps = 10", windows("[{ name = \"a\", from_s = 2, to_s = 2 }]"), at, "from_s must be the smaller one"},
          {"steps = 10", windows("[{ name = \"a\", from_s = -1 }]"), at,
           "from_s is -1; it must be a finite number >= 0"},
          {"steps = 10", windows("[{ name = \"a\", until_s = 1 }]"), at, "there are: name, from_s, to_s"},
          {"steps = 10", windows("[{ from_s = 1 }]"), at, "has no name"},
          {"steps = 10", windows("[{ name = \"after 2 s\" }]"), at, "it must be an identifier"},
          {"steps = 10", windows("[2.0]"), at, "it must be a table"},
      });
}

TEST(ConfigErrors, NameKeysThatDoNotFitTheStructure) {
  const std::string known = "structure = \"luenberger\"\nstate_matrix = [[0, 1], [-1, 0]]\noutput_matrix = [[1, 0]]\n";
  std::string luenberger = kPlantExperiment;
  luenberger = with(luenberger, "eigenvalues = [-1.0, -2.0]\n", known + "gain = [[2.0], [1.0]]\n");
  luenberger = with(luenberger, "pairs = [[-0.5, 1.0]]\n", "");
  ASSERT_EQ(error_of(luenberger), "no error");
  expect_rows(luenberger,
              {
                  {"[[0, 1], [-1, 0]]", "[[0, 1]]", "e.toml:15", "state_matrix has 1 rows; it must be 2 rows of 2"},
                  {"[[0, 1], [-1, 0]]", "[[0, 1], [0]]", "e.toml:15", "has 1 numbers in row 1"},
                  {"output_matrix = [[1, 0]]\n", "", "e.toml:13", "output_matrix is missing"},
                  {"[[2.0], [1.0]]", "[[-2.0], [1.0]]", "e.toml:17", "which does not decay"},
                  {"gain = [[2.0], [1.0]]", "gain_poles = [-1.0]", "e.toml:17", "one for each of the 2 states"},
                  {"gain = [[2.0], [1.0]]", "gain_noise = [1.0]", "e.toml:17", "[process, measurement]"},
                  {"gain = [[2.0], [1.0]]", "", "e.toml:13", "has 0 of the keys gain, gain_poles and gain_noise"},
                  {"gain =", "eigenvalues = [-1.0]\ngain =", "e.toml:17", "whose latent state is the estimate"},
                  {"[training]", "[loss]\nmap_consistency = 1\n[training]", "e.toml:21", "does not have"},
              });
  expect_rows(kPlantExperiment,
              {
                  {"\"first_order\"", "\"first_order\"\ngain = [[1.0]]", "e.toml:17", "belongs to structure"},
                  {"\"first_order\"", "\"first_order\"\nstructure = \"general\"\nstart = \"steady\"", "e.toml:18",
                   "starts from z = 0"},
                  {"\"first_order\"", "\"first_order\"\nstructure = \"general\"\nclocks_s = [1.0]", "e.toml:18",
                   "the general observer has no D"},
                  {"\"first_order\"", "\"first_order\"\nstructure = \"general\"\nfeatures = \"latent_and_output\"",
                   "e.toml:18", "reads only z"},
                  {"\"first_order\"", "\"first_order\"\nstructure = \"driven_kkl\"", "e.toml:17", "no loss trains it"},
              });
}

TEST(ConfigErrors, NameLossesThatDoNotFit) {
  const auto loss = [](const std::string& keys) { return "[loss]\n" + keys + "\n[training]"; };
  expect_rows(kPlantExperiment,
              {
                  {"[training]", loss("state_error = 0"), "e.toml:18", "every weight is zero"},
                  {"[training]", loss("state_error = -1"), "e.toml:19", "state_error is -1"},
                  {"[training]", loss("reduction = \"sum\""), "e.toml:19", "reduction is \"sum\""},
                  {"[training]", loss("collocation_low = [0, 0]"), "e.toml:19", "needs collocation = \"box\""},
                  {"[training]", loss("pde_residual = 1\ncollocation = \"box\"\ncollocation_low = [0]"), "e.toml:21",
                   "has 1 numbers; the plant has 2 states"},
                  {"[training]",
                   loss("pde_residual = 1\ncollocation = \"box\"\ncollocation_low = [0, 0]\ncollocation_high = [1, 0]"),
                   "e.toml:22", "must be above collocation_low[1]"},
                  {"[training]\n", "[training]\ngradient = \"exact\"\n", "e.toml:19", "gradient is \"exact\""},
              });
}

TEST(ConfigErrors, RefuseAnUnstableStep) {
  const std::string rk4 = with(kPlantExperiment, "\"first_order\"", "\"rk4\"");
  EXPECT_EQ(error_of(rk4), "no error");
  EXPECT_EQ(error_of(with(rk4, "-2.0]", "-139.0]")), "no error");  // |lambda| h = 2.78 at 0.02 s
  const std::string message = error_of(with(rk4, "-2.0]", "-145.0]"));
  EXPECT_THAT(message, StartsWith("e.toml:16: unstable step"));
  EXPECT_THAT(message, HasSubstr("eigenvalue -145"));
  EXPECT_THAT(message, HasSubstr("smaller sample period"));
  EXPECT_THAT(message, HasSubstr("hold = \"first_order\""));
  EXPECT_THAT(error_of(with(rk4, "[-0.5, 1.0]", "[-0.5, 200.0]")), HasSubstr("eigenvalue -0.5 +- 200i"));
  EXPECT_EQ(error_of(with(kPlantExperiment, "-2.0]", "-145.0]")), "no error");  // the exact holds are always stable
}

TEST(ConfigErrors, NameMissingOrUnusedSections) {
  EXPECT_THAT(error_of("name = \"x\"\n[observer]\neigenvalues = [-1]"), HasSubstr("neither [plant] nor [log]"));
  EXPECT_THAT(error_of(kLogExperiment + "[plant]\nmodel = \"van_der_pol\""),
              HasSubstr("[simulation] initial_low is missing"));
  EXPECT_THAT(error_of(kLogExperiment + "[simulation]\nhorizon_s = 3"),
              StartsWith("e.toml:26: [simulation] is not used with [log] alone"));
  EXPECT_THAT(error_of(with(kPlantExperiment, "eigenvalues = [-1.0, -2.0]\npairs = [[-0.5, 1.0]]\n", "")),
              StartsWith("e.toml:13: [observer] has no latent state"));
  EXPECT_THAT(error_of(with(kPlantExperiment, "[training]", "[[training]]")),
              HasSubstr("must be a section: [training]"));
}

TEST(ConfigErrors, NameBrokenExpressions) {
  const std::string text = with(kPlantExperiment, "model = \"van_der_pol\"\nparameters = { mu = 1.5 }",
                                "states = [\"a\", \"b\"]\nderivative = [\"b\", \"-a\"]\noutputs = [\"a\"]");
  EXPECT_EQ(error_of(text), "no error");
  expect_rows(text, {
                        {"\"-a\"", "\"-c\"", "e.toml:5", "[plant] derivative[1] \"-c\""},
                        {"\"-a\"", "\"-a*\"", "e.toml:5", "derivative[1]"},
                        {"\"-a\"", "\"a=1\"", "e.toml:5", "an expression cannot contain \"=\""},
                        {"outputs = [\"a\"]", "outputs = []", "e.toml:3", "has no outputs"},
                        {"\"-a\"]", "\"-a\", \"0\"]", "e.toml:3", "2 states but 3 derivative expressions"},
                        {"\"a\", \"b\"]", "\"a\", \"a\"]", "e.toml:3", "\"a\" twice"},
                        {"outputs", "inputs = [\"u\"]\ninput_field = [[\"0\"], [\"c\"]]\noutputs", "e.toml:7",
                         "[plant] input_field[1][0] \"c\""},
                        {"outputs", "inputs = [\"u\"]\ninput_field = [\"0\", \"1\"]\noutputs", "e.toml:7",
                         "input_field[0] is \"0\"; it must be a list"},
                        {"outputs", "inputs = [\"u\"]\noutputs", "e.toml:6", "the input \"u\" has no effect"},
                        {"outputs", "model = \"van_der_pol\"\noutputs", "e.toml:3", "both a model and equations"},
                    });
}

TEST(ConfigErrors, NameWrongColumns) {
  expect_rows(kLogExperiment,
              {
                  {"role = \"output\"", "role = \"outptu\"", "e.toml:12", "use \"output\"? There are \"time\""},
                  {"derivative_of = \"angle\"", "derivative_of = \"angel\"", "e.toml:16", "did you mean \"angle\"?"},
                  {"wrap = \"2pi\"", "wrap = \"pi\"", "e.toml:14", "\"2pi\" or \"360deg\""},
                  {"wrap = \"2pi\"", "wrap = -1", "e.toml:14", "wrap is -1"},
                  {"role = \"state\"", "role = \"input\"", "e.toml:16", "derivative_of"},
                  {"name = \"rate\"", "name = \"angle\"", "e.toml:16", "the name is used twice"},
                  {"name = \"rate\"\n", "", "e.toml:16", "has no name"},
                  {"train_files = [\"a.csv\"]", "", "e.toml:3", "has no train_files"},
                  {"\"latent_minus_output\"", "\"latent\"", "e.toml:25", "the output angle is an unwrapped angle"},
                  {"\"unit_gain\"", "\"ones\"", "e.toml:23", "set output_injection = \"unit_gain\""},
                  {"\"steady\"", "\"zero\"", "e.toml:24", "set start = \"steady\""},
              });
  EXPECT_EQ(error_of(with(with(kLogExperiment, "\"latent_minus_output\"", "\"latent\""), "wrap = \"2pi\"",
                          "wrap = \"2pi\"\nencoding = \"sincos\"")),
            "no error");
}

TEST(ConfigErrors, RefuseAMirrorOfAPlantThatIsNotOdd) {
  const std::string plant = with(kPlantExperiment, "model = \"van_der_pol\"\nparameters = { mu = 1.5 }",
                                 "states = [\"a\", \"b\"]\nderivative = [\"b\", \"-a + a^2\"]\noutputs = [\"a\"]");
  expect_rows(plant, {{"steps = 10", "mirror = true", "e.toml:20", "mirror = true: the plant is not odd: at x = ("}});
  EXPECT_EQ(error_of(with(kPlantExperiment, "steps = 10", "mirror = true")), "no error") << "control: odd";
  const std::string log = kLogExperiment + "[training]\nmirror = true\n";
  EXPECT_EQ(error_of(log), "no error") << "control: an unwrapped angle and its rate";
  const auto with_column = [&](const std::string& column) {
    return error_of(with(log, "[observer]", "[[log.columns]]\n" + column + "\n[observer]"));
  };
  EXPECT_EQ(with_column("name = \"temperature\"\nrole = \"state\"\nodd = false"), "no error");
  EXPECT_EQ(with_column("name = \"turn\"\nrole = \"state\"\nwrap = 360\nencoding = \"sincos\""), "no error");
  EXPECT_THAT(with_column("name = \"speed\"\nrole = \"state\"\nderivative_of = \"angle\"\nodd = false"),
              HasSubstr("changes the sign of only one of speed and angle"));
}

}  // namespace
}  // namespace nlo::trainer
