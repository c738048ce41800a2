// SPDX-License-Identifier: MIT
// Flights in a model file: they are read back unchanged, and invalid flights are refused.
#include "codegen/model/flight.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "codegen/base/vlq.h"
#include "codegen/model_file/model_file.h"
#include "codegen/model_file/validate.h"
#include "tests/codegen/example_models.h"
#include "tests/codegen/flown.h"
#include "tests/support/thrown_message.h"

namespace nlo::codegen {
namespace {

using testing::HasSubstr;

Eigen::VectorXi integers(std::initializer_list<int> values) {
  return Eigen::Map<const Eigen::VectorXi>(values.begin(), static_cast<Eigen::Index>(values.size()));
}

TEST(Vlq, EqualsTheEncodingOfSourceMaps) {
  // Differences 0, 1, -1, 15, 16, -16, by hand from the table of the source map proposal (revision 3).
  EXPECT_EQ(to_vlq(integers({0, 1, 0, 15, 31, 15})), "ACDegBhB");
  EXPECT_EQ(to_vlq({}), "");
}

TEST(Vlq, ReadsBackForAnySteps) {
  const int most = std::numeric_limits<int>::max();
  for (const auto& values : {integers({}), integers({7}), integers({0, most, -most, most, 0, -1}),
                             integers({16, -16, 511, 512, -512, 16383, 16384, -16384})}) {
    const auto read = from_vlq(to_vlq(values), most);
    ASSERT_TRUE(read.has_value());
    EXPECT_EQ(*read, values);
  }
}

TEST(Vlq, RefusesInvalidText) {
  for (const char* text : {"A B", "g", "Ag", "\xff", "gggggggA", "A=", "\n"})
    EXPECT_FALSE(from_vlq(text, 1 << 24).has_value()) << text;
  EXPECT_TRUE(from_vlq(to_vlq(integers({1 << 24})), 1 << 24).has_value());
  EXPECT_FALSE(from_vlq(to_vlq(integers({(1 << 24) + 1})), 1 << 24).has_value());
  EXPECT_FALSE(from_vlq(to_vlq(integers({1 << 23, 1 << 24, (1 << 24) + 9})), 1 << 24).has_value())
      << "the limit applies to sums";
}

TEST(FlightStep, IsAPowerOfTwoThatAFloatCanHold) {
  for (const double range : {0.0, 1e-9, 0.37, 2.0, 5e7})
    for (const double offset : {0.0, 1.0, 1e6}) {
      const double largest = offset + range, step = flight_step(range, largest);
      int exponent = 0;
      EXPECT_EQ(std::frexp(step, &exponent), 0.5) << "not a power of two: " << step;
      EXPECT_LE(largest / step, kMostFlightCount);
      EXPECT_GE(step, range * 0x1p-14);
      EXPECT_LE(step, std::max({range * 0x1p-13, largest * 0x1p-23, 0x1p-100}));
    }
}

TEST(FlightInModelFile, ReadsBackForEveryStructure) {
  for (const Model& plain : example_models()) {
    EXPECT_THAT(to_json(plain), testing::Not(HasSubstr("\"flight\""))) << "without runs there is no section";
    const Model m = flown(plain, 3, 200);
    const std::string json = to_json(m);
    const Model read = parse_model(json, "text");
    EXPECT_EQ(to_json(read), json) << m.name;
    ASSERT_EQ(read.flight.runs.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(read.flight.runs[i].outputs, m.flight.runs[i].outputs);
      // Missing inputs may be read back as 0 x 0.
      ASSERT_EQ(read.flight.runs[i].inputs.size(), m.flight.runs[i].inputs.size());
      if (m.flight.runs[i].inputs.size() > 0) {
        EXPECT_EQ(read.flight.runs[i].inputs, m.flight.runs[i].inputs);
      }
      EXPECT_EQ(read.flight.runs[i].dt, m.flight.runs[i].dt);
    }
    EXPECT_EQ(read.flight.output_step, m.flight.output_step);
    EXPECT_EQ(read.flight.input_step, m.flight.input_step);
    EXPECT_EQ(read.flight.dt_step_s, m.flight.dt_step_s);
  }
}

TEST(FlightInModelFile, NeedsTwoOrThreeBytesPerSampleAndChannel) {
  const Model m = tiny_model();
  const auto bytes = [](const Model& model) { return static_cast<double>(to_json(model).size()); };
  const double each = (bytes(flown(m, 24, 500)) - bytes(m)) / (24 * 500);
  EXPECT_LT(each, 5.0) << "three characters for a fast output, two for a time";
}

std::string refusal(const std::string& find, const std::string& replace, const Model& model) {
  std::string json = to_json(model);
  const auto at = json.find(find, json.find("\"flight\""));
  EXPECT_NE(at, std::string::npos) << find;
  if (at != std::string::npos) json.replace(at, find.size(), replace);
  return thrown_message([&] { parse_model(json, "m.json"); });
}

TEST(FlightInModelFile, ErrorsNameTheBrokenField) {
  const Model m = flown(rig_model(), 2, 50), driven = flown(driven_model(), 2, 50);
  EXPECT_EQ(refusal("\"runs\"", "\"runs\"", m), "no error");
  EXPECT_THAT(refusal("\"runs\"", "\"run\"", m), HasSubstr("m.json: flight.\"run\": unknown field"));
  EXPECT_THAT(refusal("\"runs\": [", "\"runs\": [1, ", m),
              HasSubstr("flight.runs[0]: is a JSON number; expected an object"));
  EXPECT_THAT(refusal("\"outputs\": [\"", "\"outputs\": [\"!", m),
              HasSubstr("flight.runs[0].outputs[0]: is not Base64"));
  EXPECT_THAT(refusal("\"outputs\": [\"", "\"outputs\": [\"A", m),
              HasSubstr("has 50 samples, but the row before has 51"));
  EXPECT_THAT(refusal("\"outputs\": [\"", "\"outputs\": [\"\", \"", m),
              HasSubstr("must have one for each of 2 channels"));
  EXPECT_THAT(refusal("\"output_step\": [", "\"output_step\": [1.0, ", m), HasSubstr("each of 3 channels"));
  EXPECT_THAT(refusal("\"output_step\": [", "\"output_step\": [-", m), HasSubstr("flight.output_step[0] is -"));
  EXPECT_THAT(refusal("\"dt_step_s\": ", "\"dt_step_s\": -", m), HasSubstr("flight.dt_step_s is -"));
  EXPECT_THAT(refusal("\"dt\": [\"", "\"dt\": [\"D", m), HasSubstr("0 or one each"));
  EXPECT_THAT(refusal("\"inputs\": [", "\"dts\": [", driven), HasSubstr("\"dts\": unknown field"));
}

TEST(FlightInModelFile, HasALimitOfSamplesAndOfTheirSize) {
  const auto message = [](const auto& corrupt) -> std::string {
    Model m = flown(tiny_model(), 1, 20);
    corrupt(m.flight);
    return thrown_message([&] { parse_model(to_json(m), "m.json"); });
  };
  EXPECT_THAT(message([](Flight& f) { f.runs[0].outputs = Eigen::MatrixXi::Zero(1, kMostFlightSamples + 1); }),
              HasSubstr("flight.runs: have more than 1048576 samples in total; leave some out"));
  EXPECT_THAT(message([](Flight& f) {
                FlightRun half{Eigen::MatrixXi::Zero(1, kMostFlightSamples / 2), Eigen::MatrixXi(), Eigen::VectorXi()};
                f.runs = {half, half, half};
              }),
              HasSubstr("have more than 1048576 samples"));
  EXPECT_THAT(message([](Flight& f) { f.runs[0].outputs(0, 7) = kMostFlightCount + 1; }), HasSubstr("within 2^24"));
  EXPECT_THAT(message([](Flight& f) { f.runs[0].dt(3) = 0; }), HasSubstr("flight.runs[0].dt has a count"));
  EXPECT_THAT(message([](Flight& f) { f.runs[0].outputs.resize(1, 0); }), HasSubstr("flight.runs[0]"));
}

}  // namespace
}  // namespace nlo::codegen
