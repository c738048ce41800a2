// SPDX-License-Identifier: MIT
// Any text gives an error or an experiment, never a crash or an endless loop.
#include "trainer/config/experiment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <random>

#include "tests/experiments/experiment_text.h"

namespace nlo::trainer {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

TEST(Config, ReadsBackTheTextThatItWrote) {
  const Experiment e = parse_experiment(kPlantExperiment, "e.toml");
  EXPECT_EQ(e.name, "small");
  ASSERT_TRUE(e.plant);
  EXPECT_EQ(e.plant->model, "van_der_pol");
  EXPECT_THAT(e.plant->parameters, ElementsAre(std::pair<std::string, double>("mu", 1.5)));
  EXPECT_EQ(e.simulation.horizon_s, 10.0);
  EXPECT_THAT(e.simulation.initial_low, ElementsAre(-1.0, -1.0));
  EXPECT_THAT(e.observer.eigenvalues, ElementsAre(-1.0, -2.0));
  EXPECT_THAT(e.observer.pairs, ElementsAre(std::array<double, 2>{-0.5, 1.0}));
  EXPECT_EQ(e.training.noise, (NoiseConfig{NoiseKind::kGaussian, 0.5}));
}

TEST(Config, KeepsTheDefaultsOfKeysThatAreNotGiven) {
  const Experiment e = parse_experiment(kPlantExperiment, "e.toml");
  EXPECT_EQ(e.seed, Experiment{}.seed);
  EXPECT_EQ(e.inverse_map.hidden, InverseMapConfig{}.hidden);
  EXPECT_EQ(e.training.learning_rate, TrainingConfig{}.learning_rate);
}

TEST(Config, ReadsColumnsInOrder) {
  const Experiment e = parse_experiment(kLogExperiment, "e.toml");
  ASSERT_TRUE(e.log);
  ASSERT_EQ(e.log->columns.size(), 3u);
  EXPECT_EQ(e.log->columns[0].role, ColumnRole::kTime);
  EXPECT_EQ(e.log->columns[1].column, "angle");
  EXPECT_EQ(e.log->columns[1].wrap, 6.283185307179586);
  EXPECT_EQ(e.log->columns[2].derivative_of, "angle");
  EXPECT_EQ(e.log->columns[2].column, "");
}

TEST(Config, AWrapMayBeANumberOrDegrees) {
  EXPECT_EQ(parse_experiment(with(kLogExperiment, "\"2pi\"", "360"), "e.toml").log->columns[1].wrap, 360.0);
  EXPECT_EQ(parse_experiment(with(kLogExperiment, "\"2pi\"", "\"360deg\""), "e.toml").log->columns[1].wrap, 360.0);
}

TEST(Config, ItsTextReadsBackToTheSameExperiment) {
  for (const std::string& text :
       {kPlantExperiment, kLogExperiment,
        with(kPlantExperiment, "model = \"van_der_pol\"\nparameters = { mu = 1.5 }",
             "states = [\"a\", \"b\"]\nderivative = [\"b\", \"-a\"]\noutputs = [\"a\"]\noutput_units = [\"m \\\"x\\\" "
             "\\\\ µ\"]\ninputs = [\"u\"]\ninput_field = [[\"0\"], [\"1 + a\"]]")}) {
    const Experiment once = parse_experiment(text, "e.toml");
    const Experiment twice = parse_experiment(once.source_text, "source_text");
    EXPECT_EQ(once.source_text, twice.source_text);
    EXPECT_THAT(once.source_text, HasSubstr("name = "));
  }
}

TEST(Config, ItsTextHasEveryKeyThatAffectsTheResult) {
  Experiment e = parse_experiment(kPlantExperiment, "e.toml");
  const std::string before = e.source_text;
  e.threads = 7;
  EXPECT_EQ(format_experiment(e), before);  // these keys do not affect the result
  e.training.ema = 0.5;
  EXPECT_NE(format_experiment(e), before);
}

TEST(Config, TheShippedExperimentsAreValid) {
  int found = 0;
  for (const auto& entry : std::filesystem::directory_iterator(NLO_SOURCE_DIR "/trainer/experiments")) {
    if (entry.path().extension() != ".toml") continue;
    ++found;
    EXPECT_EQ(read_experiment(entry.path().string()).name, entry.path().stem().string());
  }
  EXPECT_GE(found, 2);
}

TEST(Config, WindowsOfTheEvaluationReadBackAndAreLeftOutWhenDerived) {
  const std::string windows =
      "[evaluation]\nwindows = [{ name = \"settled\", from_s = 2.5 }, "
      "{ name = \"early\", from_s = 0.5, to_s = 5 }]\n";
  const Experiment read = parse_experiment(kPlantExperiment + windows, "f");
  ASSERT_EQ(read.evaluation.windows.size(), 2U);
  EXPECT_EQ(read.evaluation.windows[0].from_s, 2.5);
  EXPECT_FALSE(std::isfinite(read.evaluation.windows[0].to_s));
  EXPECT_EQ(read.evaluation.windows[1].to_s, 5.0);
  EXPECT_EQ(parse_experiment(read.source_text, "again").source_text, read.source_text);
  EXPECT_EQ(parse_experiment(kPlantExperiment, "f").source_text.find("[evaluation]"), std::string::npos);
}

TEST(Config, MissingCellsMayBeNumbersOrWordsAndAreReadBackUnchanged) {
  const std::string cells = "missing = [-9999, \"ERR\", 3.4e38, \"-0.50\", \"1.7976931348623157e+308\"]\n";
  const Experiment read = parse_experiment(with(kLogExperiment, "wrap = \"2pi\"", cells + "wrap = \"2pi\""), "e.toml");
  EXPECT_THAT(read.log->columns[1].missing, ElementsAre("-9999", "ERR", "3.4e+38", "-0.50", "1.7976931348623157e+308"));
  EXPECT_THAT(read.source_text,
              HasSubstr("missing = [-9999, \"ERR\", 3.4e+38, \"-0.50\", \"1.7976931348623157e+308\"]\n"));
  EXPECT_EQ(parse_experiment(read.source_text, "again").source_text, read.source_text);
  EXPECT_THAT(parse_experiment(kLogExperiment, "e.toml").source_text, Not(HasSubstr("missing")));
  EXPECT_EQ(parse_experiment(with(kLogExperiment, "[log]\n", "[log]\n" + cells), "e.toml").log->missing.size(), 5U);
}

TEST(Config, HelpNamesEveryKeyOnce) {
  const std::string help = describe_experiment_keys();
  for (const char* key : {"eigenvalues", "horizon_s", "derivative_of", "cutoff_hz", "linear_path", "early_share"})
    EXPECT_THAT(help, HasSubstr(std::string("\n  ") + key + " ")) << key;
  EXPECT_THAT(help, HasSubstr("default \"first_order\""));
}

Experiment overridden(const std::string& assignment) {
  return parse_experiment(kPlantExperiment, "e.toml", {assignment});
}

TEST(Override, ReplacesAValue) {
  EXPECT_EQ(overridden("training.steps=25").training.steps, 25);
  EXPECT_EQ(overridden("seed=9").seed, 9u);
  EXPECT_THAT(overridden("observer.eigenvalues=[-3, -4]").observer.eigenvalues, ElementsAre(-3.0, -4.0));
  EXPECT_EQ(overridden("plant.parameters.mu=2").plant->parameters[0].second, 2.0);
  EXPECT_EQ(overridden("training.noise=\"uniform:3\"").training.noise.of(0).kind, NoiseKind::kUniform);
}

TEST(Override, AddsASectionThatTheFileLeavesOut) {
  EXPECT_THAT(overridden("inverse_map.hidden=[8]").inverse_map.hidden, ElementsAre(8));
}

TEST(Override, ReadsABareWordAsText) {
  EXPECT_EQ(overridden("training.mode=full_batch").training.mode, TrainingMode::kFullBatch);
  EXPECT_EQ(overridden("training.noise=uniform:3").training.noise.of(0).scale, 3.0);
  EXPECT_FALSE(overridden("observer.learn_eigenvalues=false").observer.learn_eigenvalues);
}

TEST(Override, TheLastOneWins) {
  EXPECT_EQ(parse_experiment(kPlantExperiment, "e", {"training.steps=2", "training.steps=3"}).training.steps, 3);
}

TEST(Override, IsPartOfTheRecordedText) {
  const Experiment e = overridden("training.steps=25");
  EXPECT_EQ(parse_experiment(e.source_text, "s").training.steps, 25);
}

TEST(Override, ErrorsNameTheOverride) {
  const auto error = [](const std::string& assignment) { return error_of(kPlantExperiment, {assignment}); };
  EXPECT_THAT(error("training.stepz=3"),
              StartsWith("--set training.stepz=3: unknown key \"stepz\" in [training]; did you mean \"steps\"?"));
  EXPECT_THAT(error("training.steps=-3"), StartsWith("--set training.steps=-3: [training] steps is -3"));
  EXPECT_THAT(error("training.steps=[1"), StartsWith("--set training.steps=[1: "));
  EXPECT_THAT(error("training.steps="), StartsWith("--set training.steps=: "));
  EXPECT_THAT(error("training.steps"), HasSubstr("no KEY=VALUE"));
  EXPECT_THAT(error("=3"), HasSubstr("no KEY=VALUE"));
  EXPECT_THAT(error("training..steps=3"), HasSubstr("the key is not SECTION.KEY"));
  EXPECT_THAT(error("training.=3"), HasSubstr("the key is not SECTION.KEY"));
  EXPECT_THAT(error("name.x=3"), HasSubstr("\"name\" is not a section"));
  EXPECT_THAT(error("training.steps=1\nseed=2"), HasSubstr("more than one line"));
  EXPECT_THAT(error("training=3"), HasSubstr("it must be a section: [training]"));
  EXPECT_THAT(error("observer.hold=rk5"),
              StartsWith("--set observer.hold=rk5: [observer] hold is \"rk5\"; use \"rk4\"?"));
}

std::string repeated(const std::string& text, int times) {
  std::string result;
  for (int i = 0; i < times; ++i) result += text;
  return result;
}

TEST(BrokenToml, NamesTheLineAndHowToWriteIt) {
  EXPECT_EQ(error_of("name = \"x\"\n[plant\nmodel = \"van_der_pol\"\n"),
            "e.toml:2: \"[plant\" does not open a section: write [plant]");
  EXPECT_EQ(error_of("[[log.columns]\nname = \"x\"\n"),
            "e.toml:1: \"[[log.columns]\" does not open a section: write [[log.columns]]");
  EXPECT_EQ(error_of("seed\n"), "e.toml:1: \"seed\" has no value: write seed = VALUE, or [seed]");
  EXPECT_THAT(error_of("seed = = 3\n"), AllOf(StartsWith("e.toml:1: "), EndsWith(": seed = = 3")));
}

TEST(BrokenToml, AModelFileIsRecognisedAndRefused) {
  EXPECT_THAT(error_of("\n{\n  \"format\": 3\n}\n"), HasSubstr("this is JSON, such as a model.json"));
}

TEST(HostileToml, DeepNestingIsAnError) {
  EXPECT_THAT(error_of("x = " + std::string(100000, '[')),
              HasSubstr("e.toml:1: brackets are nested more than 32 deep"));
  EXPECT_THAT(error_of("x = " + repeated("{a=", 100000)), HasSubstr("nested more than"));
  EXPECT_THAT(error_of("\n\nx" + repeated(".a", 100000) + " = 1"), HasSubstr("e.toml:3: a key has more than 16 dots"));
  EXPECT_THAT(error_of("[x" + repeated(" . \"a\"", 100000) + "]"), HasSubstr("dots"));
}

TEST(HostileToml, BracketsInStringsAndCommentsDoNotCount) {
  const std::string brackets(200, '[');
  EXPECT_EQ(error_of("# " + brackets + "\n" + kPlantExperiment + "# " + brackets), "no error");
  EXPECT_THAT(error_of("x = \"\\\"" + brackets + "\""), HasSubstr("unknown key \"x\""));
  EXPECT_THAT(error_of("x = '''\n\"" + brackets + "'''"), HasSubstr("unknown key \"x\""));
  EXPECT_THAT(error_of("x = \"\"\"\\\"\"\"" + brackets + "\"\"\"\""), HasSubstr("unknown key \"x\""));
  EXPECT_THAT(error_of("x = '" + brackets + "\ny = " + brackets), HasSubstr("nested more than"));
}

TEST(HostileToml, RefusesTextThatIsTooLargeNotUtf8OrMalformed) {
  EXPECT_THAT(error_of(std::string(2'000'000, '#')), HasSubstr("too big"));
  EXPECT_THAT(error_of("name = \"x\"\ny = \"\xff\""), HasSubstr("e.toml:2: byte 0xFF is not text"));
  EXPECT_THAT(error_of(std::string("a\0b", 3)), HasSubstr("byte 0x00"));
  EXPECT_THAT(error_of("a = \"\xed\xa0\x80\""), HasSubstr("byte 0xED"));  // a surrogate
  EXPECT_THAT(error_of(""), HasSubstr("no name"));
  EXPECT_THAT(error_of("a = 1\na = 2"), HasSubstr("e.toml:2: "));
  EXPECT_THAT(error_of("a = [1,\n2\n"), HasSubstr("e.toml:"));
  EXPECT_THAT(error_of("a = 'x"), HasSubstr("e.toml:1: "));
}

TEST(HostileToml, RefusesTooManyKeysQuickly) {
  std::string text;
  for (int i = 0; i < 60000; ++i) text.append("a").append(std::to_string(i)).append(" = 1\n");
  EXPECT_THAT(error_of(text), HasSubstr("has 60000 keys"));
}

TEST(HostileToml, SurvivesRandomEdits) {
  std::mt19937 engine(12345);
  const std::string alphabet = "[]{}\"'=.,#\n\\ ax1-_\t\r\xc3";
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(engine()) % n; };
  int accepted = 0;
  for (int round = 0; round < 3000; ++round) {
    std::string text = round % 2 == 0 ? kPlantExperiment : kLogExperiment;
    for (std::size_t edits = 1 + below(4); edits > 0; --edits) {
      const std::size_t at = below(text.size());
      switch (below(3)) {
        case 0:
          text[at] = alphabet[below(alphabet.size())];
          break;
        case 1:
          text.insert(at, 1, alphabet[below(alphabet.size())]);
          break;
        default:
          text.erase(at, 1 + below(5));
      }
    }
    accepted += error_of(text) == "no error";
  }
  EXPECT_GT(accepted, 0);  // control: not every edit ends at the same early error
}

}  // namespace
}  // namespace nlo::trainer
