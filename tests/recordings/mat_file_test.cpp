// SPDX-License-Identifier: MIT
// MAT-files that the tests write: variables, structs and matrices as columns, in the versions that there are; damage.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <matio.h>

#include <cmath>

#include "codegen/base/error.h"
#include "tests/recordings/refusal.h"
#include "tests/support/scratch_directory.h"
#include "trainer/guess/log_guess.h"
#include "trainer/recordings/recording.h"

namespace nlo::trainer {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::Not;

constexpr std::size_t kSamples = 40;

template <class T>
matvar_t* matrix(const char* name, matio_classes of, matio_types type, std::size_t rows, std::size_t columns,
                 double scale) {
  std::vector<T> data(rows * columns);
  for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<T>(scale * static_cast<double>(i));
  std::size_t dims[2] = {rows, columns};
  return Mat_VarCreate(name, of, type, 2, dims, data.data(), 0);
}
matvar_t* doubles(const char* name, std::size_t rows, std::size_t columns, double scale) {
  return matrix<double>(name, MAT_C_DOUBLE, MAT_T_DOUBLE, rows, columns, scale);
}

/// t; y 40 x 2; across 3 x 40; single, int16; rig with angle and inner.speed; signals, two structs with values; text,
/// a number and a short vector.
std::string rig_file(const ScratchDirectory& folder, const std::string& name, mat_ft version = MAT_FT_MAT5,
                     matio_compression compression = MAT_COMPRESSION_NONE) {
  mat_t* file = Mat_CreateVer(folder.path(name).c_str(), nullptr, version);
  const auto put = [&](matvar_t* variable) {
    EXPECT_EQ(Mat_VarWrite(file, variable, compression), 0);
    Mat_VarFree(variable);
  };
  put(doubles("t", kSamples, 1, 0.01));
  put(doubles("y", kSamples, 2, 0.5));
  put(doubles("across", 3, kSamples, 1.0));
  put(matrix<float>("single", MAT_C_SINGLE, MAT_T_SINGLE, 1, kSamples, 0.25));
  put(matrix<std::int16_t>("counts", MAT_C_INT16, MAT_T_INT16, kSamples, 1, -7.0));
  put(doubles("gain", 1, 1, 0.0));
  put(doubles("short", kSamples - 1, 1, 1.0));
  std::size_t text_size[2] = {1, 5};
  char text[] = "hello";
  put(Mat_VarCreate("note", MAT_C_CHAR, MAT_T_UINT8, 2, text_size, text, 0));

  std::size_t one[2] = {1, 1}, two[2] = {1, 2};
  const char* outer[] = {"angle", "inner"};
  const char* inner[] = {"speed"};
  const char* signal[] = {"values"};
  matvar_t* rig = Mat_VarCreateStruct("rig", 2, one, outer, 2);
  matvar_t* part = Mat_VarCreateStruct("inner", 2, one, inner, 1);
  Mat_VarSetStructFieldByName(part, "speed", 0, doubles("speed", kSamples, 1, 3.0));
  Mat_VarSetStructFieldByName(rig, "angle", 0, doubles("angle", kSamples, 1, 2.0));
  Mat_VarSetStructFieldByName(rig, "inner", 0, part);
  put(rig);
  matvar_t* signals = Mat_VarCreateStruct("signals", 2, two, signal, 1);
  Mat_VarSetStructFieldByName(signals, "values", 0, doubles("values", kSamples, 1, 4.0));
  Mat_VarSetStructFieldByName(signals, "values", 1, doubles("values", kSamples, 1, 5.0));
  put(signals);
  Mat_Close(file);
  return folder.path(name);
}

const WantedColumns kAll{"t",
                         {{"y(1)"},
                          {"y(2)"},
                          {"across(3)"},
                          {"single"},
                          {"counts"},
                          {"rig.angle"},
                          {"rig.inner.speed"},
                          {"signals(2).values"}}};

void expect_rig(const Recording& log) {
  ASSERT_EQ(log.numbers.rows(), static_cast<Eigen::Index>(kSamples));
  ASSERT_EQ(log.numbers.cols(), 9);
  for (int k = 0; k < log.numbers.rows(); ++k) {
    EXPECT_EQ(log.numbers(k, 0), 0.01 * k);
    EXPECT_EQ(log.numbers(k, 1), 0.5 * k);
    EXPECT_EQ(log.numbers(k, 2), 0.5 * (k + static_cast<int>(kSamples)));
    EXPECT_EQ(log.numbers(k, 3), 3.0 * k + 2.0);
    EXPECT_EQ(log.numbers(k, 4), 0.25 * k);
    EXPECT_EQ(log.numbers(k, 5), -7.0 * k);
    EXPECT_EQ(log.numbers(k, 6), 2.0 * k);
    EXPECT_EQ(log.numbers(k, 7), 3.0 * k);
    EXPECT_EQ(log.numbers(k, 8), 5.0 * k);
  }
}

TEST(MatFile, HasVariablesFieldsAndColumnsOfMatricesInEachVersion) {
  const ScratchDirectory folder;
  expect_rig(read_recording(rig_file(folder, "plain.mat"), kAll));
  expect_rig(read_recording(rig_file(folder, "compressed.mat", MAT_FT_MAT5, MAT_COMPRESSION_ZLIB), kAll));
  expect_rig(read_recording(rig_file(folder, "new.mat", MAT_FT_MAT73), kAll));
}

TEST(MatFile, NamesFileVariableAndFixOfWhatCannotBeRead) {
  const ScratchDirectory folder;
  const std::string file = rig_file(folder, "rig.mat");
  const auto of = [&](const std::string& heading) { return refusal(file, {"t", {{heading}}}); };
  EXPECT_THAT(of("singel"), HasSubstr("rig.mat: no variable \"singel\" among t, y, across, single"));
  EXPECT_THAT(of("singel"), HasSubstr("did you mean \"single\"?"));
  EXPECT_THAT(of("rig.angel"), HasSubstr("no field \"angel\" of rig among angle, inner; did you mean \"angle\"?"));
  EXPECT_THAT(of("y"), HasSubstr("y is 40 x 2: write y(1) for its first column"));
  EXPECT_THAT(of("y(3)"), HasSubstr("y(3) is 40 x 2: there is no (3)"));
  EXPECT_THAT(of("short"), HasSubstr("short is 39 x 1, and the log has 40 samples"));
  EXPECT_THAT(of("gain"), HasSubstr("gain is 1 x 1, and the log has 40 samples"));
  EXPECT_THAT(of("note"), HasSubstr("note is text: expected a vector of numbers"));
  EXPECT_THAT(of("rig"), HasSubstr("rig is no number"));
  EXPECT_THAT(of("t.angle"), HasSubstr("t is not a struct"));
  EXPECT_THAT(of("signals.values"), HasSubstr("signals is 2 structs: write signals(1).values to signals(2).values"));
  EXPECT_THAT(of("signals(3).values"), HasSubstr("signals is 2 structs"));
  EXPECT_THAT(of("y(0)"), HasSubstr("does not name a variable"));
  EXPECT_THAT(refusal(folder.write("text.mat", "t,y\n0,1\n"), kAll), HasSubstr("text.mat: is not a MAT-file"));
}

TEST(MatFile, OffersWhatHasTheLengthThatMostHave) {
  const ScratchDirectory folder;
  const Recording log = read_recording(rig_file(folder, "rig.mat"), {});
  EXPECT_THAT(log.headings,
              IsSupersetOf({"t", "y(1)", "y(2)", "across(1)", "counts", "rig.angle", "signals(1).values"}));
  EXPECT_THAT(log.headings, Not(::testing::Contains("short")));
  const GuessedLog guess = guess_log({folder.path("rig.mat")}, {{"rig.inner.speed"}, {"y(1)"}, {}, 0.0});
  EXPECT_EQ(guess.clock.heading, "t");
  EXPECT_EQ(guess.rows, static_cast<Eigen::Index>(kSamples));
}

TEST(MatFile, IsReadWholeOrRefusedWhereverItEnds) {
  const ScratchDirectory folder;
  for (const matio_compression compression : {MAT_COMPRESSION_NONE, MAT_COMPRESSION_ZLIB}) {
    const std::string whole =
        folder.read(std::filesystem::path(rig_file(folder, "rig.mat", MAT_FT_MAT5, compression)).filename());
    int refused = 0;
    for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 150) {
      const std::string error = refusal(folder.write("cut.mat", whole.substr(0, length)), kAll);
      EXPECT_NE(error, "") << length << " of " << whole.size();
      refused += error.empty() ? 0 : 1;
    }
    EXPECT_GT(refused, 100);
  }
}

}  // namespace
}  // namespace nlo::trainer
