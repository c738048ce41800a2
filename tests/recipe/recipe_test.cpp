// SPDX-License-Identifier: MIT
#include "trainer/choose/recipe.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include "codegen/base/error.h"
#include "trainer/choose/mode_banks.h"
#include "trainer/choose/readout_probe.h"
#include "trainer/choose/resonances.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/shipped.h"
#include "trainer/experiments/training_sets.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::string kDraft = R"(name = "draft"
[plant]
model = "van_der_pol"
[simulation]
horizon_s = 10.0
sample_period_s = 0.05
initial_low = [-1.0, -1.0]
initial_high = [1.0, 1.0]
[training]
trajectories_per_step = 8  # quick pilots: what is derived here does not hang on them
samples_per_step = 256
)";

constexpr const char* kLinearLatent = "observer.structure=kkl";  // other structures have no eigenvalues

constexpr double kRounding = 0.01;  // banks are printed with three digits

Recipe derived(const std::string& text, const std::vector<std::string>& overrides = {}) {
  const DraftExperiment draft = parse_draft(text, "draft.toml", overrides);
  EXPECT_FALSE(draft.complete);
  const TrainingSets sets = simulate_training_sets(experiment_for_data(draft));
  return derive_recipe(draft, sets.training, sets.validation);
}

TEST(Draft, IsAFileWithoutEigenvalues) {
  EXPECT_FALSE(parse_draft(kDraft, "d.toml").complete);
  EXPECT_TRUE(parse_draft(kDraft, "d.toml", {"observer.eigenvalues=[-1.0]"}).complete);
  EXPECT_THROW(parse_experiment(kDraft, "d.toml"), codegen::Error);
  EXPECT_THROW(parse_draft(kDraft, "d.toml", {"observer.eigenvalues=[]"}), codegen::Error)
      << "the key is given, but empty";
}

TEST(Draft, IsAFileWithUnitsAndWithoutSteps) {
  for (const char* structure : {"observer.structure=gated", "observer.structure=prior"}) {
    EXPECT_FALSE(parse_draft(kDraft, "d.toml", {structure}).complete) << structure;
    EXPECT_TRUE(parse_draft(kDraft, "d.toml", {structure, "training.steps=100"}).complete) << structure;
    const std::string defaults = parse_experiment(kDraft, "d.toml", {structure}).source_text;
    EXPECT_EQ(parse_experiment(defaults, "again").source_text, defaults)
        << "a command that does not train reads the defaults";
  }
  EXPECT_TRUE(
      parse_draft(kDraft, "d.toml", {"observer.structure=general", "observer.eigenvalues=[-1.0, -2.0]"}).complete)
      << "no recipe has settings for this structure";
}

TEST(Draft, LeavesShippedExperimentsAsTheyAre) {
  for (const ShippedExperiment& shipped : shipped_experiments()) {
    const DraftExperiment draft = parse_draft(shipped.text, std::string(shipped.name));
    EXPECT_TRUE(draft.complete) << shipped.name;
    EXPECT_EQ(draft.experiment.source_text, parse_experiment(shipped.text, std::string(shipped.name)).source_text);
  }
}

TEST(Draft, DiffersFromAFileThatGivesTheDefaultExplicitly) {
  EXPECT_NE(parse_draft(kDraft, "d.toml").experiment.source_text,
            parse_draft(kDraft, "d.toml", {"training.steps=1000"}).experiment.source_text);
}

TEST(Recipe, ReadsBackToTheSameExperiment) {
  const Recipe recipe = derived(kDraft, {kLinearLatent});
  const Experiment again = parse_experiment(recipe.experiment.source_text, "again");
  EXPECT_EQ(again.source_text, recipe.experiment.source_text);
  EXPECT_FALSE(again.observer.eigenvalues.empty() && again.observer.pairs.empty());
}

TEST(Recipe, IsTheSameForAnyNumberOfThreads) {
  EXPECT_EQ(derived(kDraft, {"threads=1"}).experiment.source_text,
            derived(kDraft, {"threads=3"}).experiment.source_text);
}

TEST(Recipe, KeepsTheKeysOfTheFile) {
  const Recipe recipe = derived(kDraft, {"observer.clocks_s=[0.7]", "observer.features=latent", "observer.start=zero",
                                         "inverse_map.hidden=[8]", "inverse_map.linear_path=false", "training.steps=77",
                                         "training.mirror=false", "simulation.trajectories=30", "loss.scale=physical"});
  for (const char* line :
       {"clocks_s = [0.7]", "features = \"latent\"", "start = \"zero\"", "hidden = [8]", "linear_path = false",
        "steps = 77", "mirror = false", "trajectories = 30", "scale = \"physical\""})
    EXPECT_THAT(recipe.experiment.source_text, HasSubstr(std::string("\n") + line + "\n")) << line;
}

/// Returns min |Re lambda| of the derived experiment [1/s].
double slowest(const Recipe& recipe) {
  const ObserverConfig& observer = recipe.experiment.observer;
  return ModeBank{.pairs = observer.pairs, .real = observer.eigenvalues}.slowest();
}

TEST(Recipe, IsSlowerForASlowerPlant) {
  // The same oscillator ten times slower: all times are ten times as long.
  const std::string plant = R"toml(name = "clocked"
[plant]
states = ["a", "b"]
derivative = ["rate*b", "rate*(2*(1 - a^2)*b - a)"]
parameters = { rate = 1.0 }
output_names = ["y"]
outputs = ["a"]
[simulation]
horizon_s = 20.0
sample_period_s = 0.05
initial_low = [-1.0, -1.0]
initial_high = [1.0, 1.0]
[training]
noise = "gaussian:0.1"
trajectories_per_step = 8
samples_per_step = 256
)toml";
  const double fast = slowest(derived(plant, {kLinearLatent}));
  const double slow = slowest(derived(plant, {kLinearLatent, "plant.parameters.rate=0.1", "simulation.horizon_s=200.0",
                                              "simulation.sample_period_s=0.5"}));
  EXPECT_NEAR(fast / slow, 10.0, 0.1);
}

// A cart on a track with an unknown initial state, of which only the position is measured. While the observer forgets
// its initial state, the best map changes with time.
const std::string kCart = R"toml(name = "cart"
[plant]
states = ["position", "speed"]
derivative = ["speed", "-0.5 * speed"]
output_names = ["y"]
outputs = ["position"]
[simulation]
horizon_s = 10.0
sample_period_s = 0.02
initial_low = [-1.0, -5.0]
initial_high = [1.0, 5.0]
[training]
noise = "gaussian:0.05"
trajectories_per_step = 8
samples_per_step = 256
)toml";

TEST(Recipe, ChoosesClockProductsIfTheTransientDominatesTheError) {
  const Recipe recipe = derived(kCart, {kLinearLatent});
  EXPECT_THAT(recipe.experiment.source_text, HasSubstr("clock_products = \"all\""));
  EXPECT_THAT(recipe.text, HasSubstr("their products with clocks"));
  const std::vector<double>& clocks = recipe.experiment.observer.clocks_s;
  ASSERT_FALSE(clocks.empty());
  EXPECT_NEAR(clocks.front(), 1.0 / slowest(recipe), kRounding * clocks.front());
}

TEST(Recipe, KeepsClocksThatTheFileGives) {
  const std::string text = derived(kCart, {"observer.clocks_s=[0.7]"}).experiment.source_text;
  EXPECT_THAT(text, HasSubstr("\nclocks_s = [0.7]\n"));
  EXPECT_THAT(text, Not(HasSubstr("clock_products")));
}

// A spring that rings for ten periods. Its force is known; the noise of its measured position is larger than its
// motion.
const std::string kSpring = R"toml(name = "spring"
[plant]
states = ["position", "speed"]
derivative = ["speed", "-400 * position - 0.8 * speed + force"]
inputs = ["force"]
output_names = ["y"]
outputs = ["position"]
[simulation]
horizon_s = 20.0
sample_period_s = 0.01
trajectories = 60
initial_low = [-0.1, -2.0]
initial_high = [0.1, 2.0]
[excitation]
low = [-40.0]
high = [40.0]
[training]
noise = "gaussian:0.5"
trajectories_per_step = 8
samples_per_step = 256
)toml";

TEST(Recipe, ChoosesTheFilterIfTheEquationsOfThePlantHold) {
  // A linear plant with white noise: the Kalman filter from which a prior starts is the best possible estimator, so
  // learned corrections cannot lower its error.
  std::vector<std::string> keys = {"simulation.process_noise=[0.0, 0.05]", "training.ema=0.5",
                                   "inverse_map.hidden=[8]"};
  const Recipe recipe = derived(kSpring, keys);
  EXPECT_EQ(recipe.experiment.observer.structure, "prior") << recipe.text;
  EXPECT_THAT(recipe.text, HasSubstr("structure \"prior\" with units = 0 is chosen"));
  EXPECT_THAT(recipe.experiment.source_text, HasSubstr("\nunits = 0\n"));
  EXPECT_EQ(recipe.experiment.training.ema, 0.5) << "the file gives it";
  EXPECT_EQ(recipe.experiment.inverse_map.hidden, std::vector<int>{8}) << "the file gives it";

  keys.emplace_back("observer.structure=prior");
  const Recipe named = derived(kSpring, keys);
  EXPECT_EQ(named.experiment.source_text, recipe.experiment.source_text) << "both have the same settings";
  EXPECT_THAT(named.text, Not(HasSubstr("warning"))) << "process noise says how far the equations may be wrong";
}

TEST(Recipe, KeepsTheStructureAndTheUnitsOfTheFile) {
  for (const char* structure : {"gated", "prior"}) {
    const Recipe recipe = derived(kSpring, {std::string("observer.structure=") + structure, "observer.units=8",
                                            "observer.rates=[1.0, 2.0]", "loss.scale=physical"});
    for (const std::string& line : {"structure = \"" + std::string(structure) + "\"", std::string("units = 8"),
                                    std::string("rates = [1.0, 2.0]"), std::string("scale = \"physical\"")})
      EXPECT_THAT(recipe.experiment.source_text, HasSubstr("\n" + line + "\n"));
    EXPECT_THAT(recipe.text, HasSubstr("8 units, at first with rates from 1 to 2 1/s"));
    EXPECT_EQ(recipe.text.find("warning: in flight a prior may be worse") != std::string::npos,
              std::string_view(structure) == "prior")
        << "the plant is simulated exactly: " << recipe.text;
  }
}

TEST(Recipe, MakesAFilterOfAPriorWithoutUnits) {
  const Recipe recipe = derived(kSpring, {"observer.structure=prior", "observer.units=0"});
  for (const char* line : {"units = 0", "hidden = []", "linear_path = true", "readout = \"network\"", "steps = 0"})
    EXPECT_THAT(recipe.experiment.source_text, HasSubstr("\n" + std::string(line) + "\n"));
  EXPECT_THAT(recipe.text, HasSubstr("structure \"prior\" without units: an extended Kalman filter"));
}

TEST(Recipe, TriesNoPriorOnAPlantThatIsSimulatedExactly) {
  // A prior would be chosen, and would fail on the real plant, whose parameters differ.
  const Recipe recipe = derived(kSpring);
  EXPECT_NE(recipe.experiment.observer.structure, "prior");
  EXPECT_THAT(recipe.text, HasSubstr("structure \"prior\" was not tried: it would trust the equations completely"));
}

TEST(Recipe, TriesNoPriorForAnEncoderThatCountsWithoutEnd) {
  // A prior holds the count as a state, and a flight beyond the range of training would clamp it.
  const Recipe recipe = derived(kSpring, {"plant.derivative=[\"speed\", \"force - friction * speed\"]",
                                          "plant.parameters={ friction = [0.4, 0.6] }"});
  EXPECT_NE(recipe.experiment.observer.structure, "prior");
  EXPECT_THAT(recipe.text, HasSubstr("structure \"prior\" was not tried: position may count without end"));
}

std::string tank(const std::string& outflow) {
  return "name = \"tank\"\n[plant]\nstates = [\"level\"]\nderivative = [\"0.5 - 0.5 * " + outflow + "\"]\n" +
         R"toml(
output_names = ["y"]
outputs = ["level"]
[simulation]
horizon_s = 10.0
sample_period_s = 0.05
initial_low = [0.1]
initial_high = [4.0]
process_noise = [0.01]
[training]
noise = "gaussian:0.2"
trajectories_per_step = 8
samples_per_step = 256
)toml";
}

TEST(Recipe, SaysWhyAPriorWasNotTried) {
  // The estimate of a level may fall below -1, where the logarithm is not defined.
  const Recipe recipe = derived(tank("ln(1 + level)"));
  EXPECT_NE(recipe.experiment.observer.structure, "prior");
  EXPECT_THAT(recipe.text, HasSubstr("structure \"prior\" was not tried: equations.derivative[0] has no bound"));
}

TEST(Recipe, TriesAPriorWithTheSquareRootOfAState) {
  EXPECT_THAT(derived(tank("sqrt(level)")).text, Not(HasSubstr("\"prior\" was not tried")));
}

TEST(Recipe, HasNoModeSlowerThanAFifthOfTheTotalTimeOfItsRuns) {
  // An almost constant state behind large noise: the longer the average, the better the estimate.
  const std::string plant = R"toml(name = "level"
[plant]
states = ["a"]
derivative = ["-0.02 * a"]
output_names = ["y"]
outputs = ["a"]
[simulation]
horizon_s = 20.0
sample_period_s = 0.1
initial_low = [1.0]
initial_high = [2.0]
[observer]
structure = "kkl"  # gated units have no eigenvalues
[training]
noise = "gaussian:0.5"
trajectories_per_step = 8
samples_per_step = 256
)toml";
  constexpr double kFifthOfARun = 4.0;
  const double of_one_run = slowest(derived(plant, {"simulation.trajectories=1"}));
  EXPECT_GE(of_one_run, (1.0 - kRounding) / kFifthOfARun);
  EXPECT_TRUE(std::isfinite(of_one_run));
  EXPECT_LT(slowest(derived(plant, {"simulation.trajectories=40"})),
            1.0 / kFifthOfARun);  // many runs need no longer average
}

TEST(Recipe, DoesNotMirrorRunsWhoseInitialStatesLieOnOneSide) {
  EXPECT_TRUE(derived(kDraft).experiment.training.mirror);
  EXPECT_FALSE(derived(kDraft, {"simulation.initial_low=[0.0, -1.0]"}).experiment.training.mirror);
}

/// x1' = x2, x2' = -x1, y = x1: linear, so that a linear readout of z is exact once the start is forgotten.
Experiment oscillator(const std::string& observer, const std::string& outputs = R"("a")") {
  return parse_experiment(R"(name = "oscillator"
[plant]
states = ["a", "b"]
derivative = ["b", "-a"]
output_names = ["y"]
outputs = [)" + outputs + R"(]
[simulation]
horizon_s = 40.0
sample_period_s = 0.05
trajectories = 40
initial_low = [-1.0, -1.0]
initial_high = [1.0, 1.0]
[observer]
output_injection = "unit_gain"
start = "steady"
)" + observer,
                          "o.toml");
}

ReadoutError error_of(const Experiment& experiment, const std::string& threads = "1") {
  Experiment threaded = experiment;
  threaded.threads = std::stoi(threads);
  const TrainingSets sets = simulate_training_sets(threaded);
  return ReadoutProbe(threaded, sets.training).error(threaded, 64, 4000);
}

TEST(ReadoutProbe, LinearReadoutIsExactForALinearPlant) {
  const ReadoutError fast = error_of(oscillator("eigenvalues = [-2.0, -4.0]"));
  const ReadoutError slow = error_of(oscillator("eigenvalues = [-0.02, -0.03]"));
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_LT(fast.linear[i], 0.2);                   // the error of the transient alone: 2 of 40 s
    EXPECT_GT(slow.linear[i], 2.0 * fast.linear[i]);  // it never forgets its initial state
  }
  EXPECT_LT(fast.mean_log(), slow.mean_log());
}

TEST(ReadoutProbe, PrefersANonlinearReadoutForANonlinearPlant) {
  const ReadoutError line = error_of(oscillator("eigenvalues = [-2.0, -4.0]"));
  const ReadoutError curve = error_of(oscillator("eigenvalues = [-2.0, -4.0]", "\"exp(2*a)\""));
  EXPECT_LT(curve.curved[0], 0.6 * curve.linear[0]);
  EXPECT_LT(line.linear[0], curve.linear[0]);
}

TEST(ReadoutProbe, ReportsAStateThatTheOutputsDoNotDetermine) {
  const ReadoutError error = error_of(oscillator("eigenvalues = [-2.0, -4.0]", R"("0.0")"));
  for (const double share : error.linear) EXPECT_NEAR(share, 1.0, 0.05);
}

TEST(ReadoutProbe, GivesTheSameNumbersForAnyNumberOfThreads) {
  const Experiment experiment = oscillator("eigenvalues = [-2.0, -4.0]\n[training]\nnoise = \"gaussian:0.1\"");
  const ReadoutError one = error_of(experiment, "1"), three = error_of(experiment, "3");
  EXPECT_EQ(one.linear, three.linear);
  EXPECT_EQ(one.curved, three.curved);
}

TEST(ModeBanks, DecayWithinARunAndStayBelowTheSampleRate) {
  for (const double period_s : {1e-4, 0.02, 1.0})
    for (const double samples : {200.0, 2500.0, 20000.0}) {
      const auto banks = mode_banks(period_s, samples * period_s, 100);
      ASSERT_GE(banks.size(), 10U);
      for (const ModeBank& bank : banks) {
        EXPECT_GE(bank.slowest() * samples * period_s, 1.0 - kRounding);
        EXPECT_LE(bank.fastest() * period_s, 1.5 + kRounding);
      }
    }
}

TEST(ModeBanks, ScaleWithTheUnitOfTime) {
  const auto seconds = mode_banks(0.01, 10.0, 100), milliseconds = mode_banks(10.0, 10000.0, 100);
  ASSERT_EQ(seconds.size(), milliseconds.size());
  for (std::size_t i = 0; i < seconds.size(); ++i)
    EXPECT_NEAR(seconds[i].slowest(), 1000.0 * milliseconds[i].slowest(), kRounding * seconds[i].slowest());
}

/// Logarithm of an error that grows with the distance between each of these poles and the nearest pair
/// (pseudo-hyperbolic distance of the half plane). The error is 0 at the pole and 1 far from it.
double log_distance(const ModeBank& bank, const std::vector<std::complex<double>>& poles) {
  double sum = 0.0;
  for (const std::complex<double> pole : poles) {
    double nearest = 1.0;
    for (const auto& [re, im] : bank.pairs)
      nearest = std::min(nearest, std::abs(std::complex<double>(re, im) - pole) /
                                      std::abs(std::complex<double>(re, im) + std::conj(pole)));
    sum += nearest;
  }
  return std::log(0.1 + sum);
}

ModeBank with_resonances_at(const std::vector<std::complex<double>>& poles, double longest_s = 10.0, int rows = 20) {
  const ModeBank bank{.pairs = {}, .real = {-1.0, -4.0}};
  return with_resonances(bank, 0.01, longest_s, rows,
                         [&](const ModeBank& tried) { return log_distance(tried, poles); });
}

TEST(Resonances, AreFoundAtThePoles) {
  const ModeBank bank = with_resonances_at({{-1.5, 40.0}, {-3.0, 12.0}});
  ASSERT_EQ(bank.pairs.size(), 2U);
  for (const std::complex<double> pole : {std::complex<double>(-1.5, 40.0), {-3.0, 12.0}}) {
    double nearest = 1e9;
    for (const auto& [re, im] : bank.pairs) nearest = std::min(nearest, std::abs(std::complex<double>(re, im) - pole));
    EXPECT_LT(nearest, 0.4 * -pole.real()) << pole;  // the last step of the search is 1.25 % of the frequency
  }
}

TEST(Resonances, AreNotAddedIfTheyDoNotReduceTheError) {
  EXPECT_TRUE(with_resonances_at({}).pairs.empty());
}

TEST(Resonances, StayWithinTheNumberOfRowsAndTheLongestTimeConstant) {
  EXPECT_TRUE(with_resonances_at({{-1.5, 40.0}}, 10.0, 3).pairs.empty());  // a pair has two rows, the bank two already
  for (const auto& [re, im] : with_resonances_at({{-0.02, 40.0}}, 1.0).pairs) EXPECT_LE(re, -1.0 + kRounding);
}

TEST(Recipe, PlacesALightlyDampedPairAtTheResonanceOfAPlant) {
  const Recipe recipe = derived(kSpring, {kLinearLatent});
  bool found = false;  // poles at -0.4 +- 20 i
  for (const auto& [re, im] : recipe.experiment.observer.pairs)
    found = found || (std::abs(im - 20.0) < 1.0 && re > -1.5);
  EXPECT_TRUE(found) << recipe.text;
}

TEST(ModeBanks, HaveFewerRowsIfThereAreManyChannels) {
  for (const int most : {1, 2, 4})
    for (const ModeBank& bank : mode_banks(0.01, 10.0, most)) EXPECT_LE(bank.rows(), std::max(most, 2));
}

}  // namespace
}  // namespace nlo::trainer
