// SPDX-License-Identifier: MIT
#include "codegen/targets/fmu.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <string>

#include "codegen/base/child.h"
#include "codegen/base/error.h"
#include "codegen/base/zip.h"
#include "tests/codegen/example_models.h"
#include "tests/support/scratch_directory.h"

namespace nlo::codegen {
namespace {

using ::testing::HasSubstr;

std::map<std::string, std::string> by_path(const std::vector<NamedText>& files) {
  std::map<std::string, std::string> texts;
  for (const NamedText& file : files) texts[file.path] = file.text;
  return texts;
}

std::string description_of(const Model& model) {
  return by_path(unzipped(fmu_of_sources(PreparedExport(model)).front().text))["modelDescription.xml"];
}

std::string token_of(const Model& model) {
  const std::string text = description_of(model), before = "instantiationToken=\"";
  return text.substr(text.find(before) + before.size(), 34);
}

TEST(Zip, HasTheStandardChecksumAndEveryByte) {
  EXPECT_EQ(crc32("123456789"), 0xCBF43926U) << "the published check value of CRC-32";
  const std::string all("\0\1PK\3\4\xff", 7);
  const std::string archive = zip({{"empty", ""}, {"a/b", all}});
  const auto files = by_path(unzipped(archive));
  EXPECT_EQ(files.size(), 2U);
  EXPECT_EQ(files.at("a/b"), all);
  std::string damaged = archive;
  damaged[damaged.find(all)] = '\2';
  EXPECT_THROW(unzipped(damaged), Error);
  EXPECT_THROW(unzipped(archive.substr(0, archive.find(all) + 2)), Error);
  EXPECT_THROW(unzipped("no archive"), Error);
}

TEST(Child, SaysWhyItFailed) {
  constexpr auto kLong = std::chrono::seconds(60);
  const ScratchDirectory scratch;
  EXPECT_EQ(run_child({"true"}, scratch.path(), kLong), "");
  EXPECT_EQ(run_child({"sh", "-c", "echo some words; exit 3"}, scratch.path(), kLong), "sh failed: some words\n");
  EXPECT_THAT(run_child({"no-such-program"}, scratch.path(), kLong), HasSubstr("no-such-program could not be started"));
  EXPECT_EQ(run_child({"sleep", "60"}, scratch.path(), std::chrono::seconds(0)), "sleep did not finish within 0 s");
  const ChildEnd apart =
      end_of_child({"sh", "-c", "echo words; echo progress >&2; exit 3"}, scratch.path(), kLong, "out");
  EXPECT_EQ(apart.exit_code, 3);
  EXPECT_EQ(apart.failure, "sh failed: progress\n");
  EXPECT_EQ(scratch.read("out"), "words\n");
  EXPECT_EQ(end_of_child({"true"}, scratch.path(), kLong).exit_code, 0);
  EXPECT_EQ(end_of_child({"no-such-program"}, scratch.path(), kLong).exit_code, -1);
}

TEST(Fmu, TokenChangesWithTheModel) {
  Model m = tiny_model();
  const std::string token = token_of(m);
  EXPECT_THAT(token, ::testing::MatchesRegex("\\{[0-9a-f]{32}\\}"));
  EXPECT_EQ(token_of(tiny_model()), token);
  m.states[0].unit = "rad/h";
  EXPECT_NE(token_of(m), token);
  m = tiny_model();
  networks(m).back().network->layers.back().weights(0, 0) *= 1.001;
  EXPECT_NE(token_of(m), token);
}

TEST(Fmu, UserTextStaysWithinItsAttribute) {
  Model m = tiny_model();
  m.states[0].unit = "\"/><&\x01\n'";
  EXPECT_THAT(description_of(m), HasSubstr("unit=\"&quot;/&gt;&lt;&amp;_\n&#39;\""));
}

}  // namespace
}  // namespace nlo::codegen
