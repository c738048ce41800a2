// SPDX-License-Identifier: MIT
// What a model says, its text says: each field of a model file is changed, and the text that was right is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/model_file/model_file.h"
#include "codegen/readback/folding.h"
#include "tests/codegen/readback_text.h"

namespace nlo::codegen {
namespace {

using testing::HasSubstr;

/// "/inverse_map/layers/0/bias/3": "inverse_map.layers.#.bias.#".
std::string field_of(const std::string& pointer) {
  std::string field;
  std::istringstream parts(pointer.substr(1));
  for (std::string part; std::getline(parts, part, '/');)
    field += (field.empty() ? "" : ".") + (part.find_first_not_of("0123456789") == std::string::npos ? "#" : part);
  return field;
}

/// What no text says, or not this one: facts for people, proofs, what the arithmetic does not read.
bool is_left_out(const std::string& field, TextForm form, const Model& m) {
  const auto ends = [&](const char* with) { return field.ends_with(with); };
  const std::string_view structure = structure_name(m);
  if (field.starts_with("flight.") || field.starts_with("provenance.") || field.starts_with("contraction."))
    return true;
  if (ends(".unit") || ends("largest_activations.#") || field == "states.#.wrap") return true;
  if (field == "monitor.hours" || field == "monitor.false_alarms_per_hour") return true;
  if (field == "outputs.#.name") return m.measured() < m.ny();            // of one that is computed: a comment
  if (structure == "window" && field == "initial_latent.#") return true;  // it starts from the first reading
  // One layer has no activation; T* of vectors no bias that counts.
  if (ends("activation")) return structure == "gated" || structure == "prior" || structure == "carried";
  if (structure == "carried") return ends("feature_mean.#") || ends("feature_scale.#");
  // To structures of their own steps both are a ramp, or the last reading.
  if (field == "hold") return structure != "kkl" && structure != "driven_kkl";
  if (form == TextForm::kCpp) return false;
  return field.starts_with("error.") || field == "drive.forward_map.output_mean.#";  // T flies as its derivative
}

/// A number, a choice or a name, otherwise.
std::vector<nlohmann::json> others(const nlohmann::json& value) {
  if (value.is_boolean()) return {!value.get<bool>()};
  if (value.is_number_integer()) return {value.get<int>() + 1};
  if (value.is_number()) return {std::abs(value.get<double>()) < 1e-9 ? 0.01 : value.get<double>() * 1.01};
  std::vector<nlohmann::json> words;
  for (const char* word : {"zero_order", "first_order", "rk4", "tanh", "relu", "silu", "other", "y1 * y1"})
    if (value.is_string() && value != word) words.emplace_back(word);
  return words;
}

TEST(ReadBackFields, EachFieldOfAModelFileIsInTheText) {
  std::set<std::string> seen;
  std::vector<Model> models = models_of_structures();
  models.insert(models.end(), {computed_model(), saturating_rig_model(), with_error(rig_model(), 3)});
  for (const Model& model : models)
    for (const Form& form : {kForms[0], kForms[1]}) {
      const Text t(model, {}, form);
      const nlohmann::json file = nlohmann::json::parse(to_json(model)), flat = file.flatten();
      std::map<std::string, int> tried;
      for (const auto& [pointer, value] : flat.items()) {
        const std::string field = field_of(pointer);
        if (is_left_out(field, form.form, model) || ++tried[field] > 2) continue;
        for (const nlohmann::json& other : others(value)) {
          nlohmann::json changed = file;
          changed[nlohmann::json::json_pointer(pointer)] = other;
          std::optional<PreparedExport> prepared;
          try {
            prepared.emplace(parse_model(changed.dump(), "m.json"));
          } catch (const Error&) {
            continue;  // no model
          }
          EXPECT_THROW(check_text(*prepared, t.form, {{"FILE", t.text}}), Error)
              << t.what << ": " << pointer << " = " << other;
          seen.insert(field);
        }
      }
    }
  EXPECT_GT(seen.size(), 60U);
}

TEST(ReadBackFields, AFormulaThatComputesOtherwiseIsSeen) {
  for (const Form& form : kForms) {
    const Text prior(prior_functions_model(), {}, form), computed(computed_model(), {}, form);
    const auto edited = [](const Text& t, const std::string& from, const std::string& to) {
      std::string text = t.text;
      text.replace(text.find(from), from.size(), to);
      return t.refusal(text);
    };
    EXPECT_THAT(edited(prior, "magnitude(x[1])", "magnitude(x[0])"), HasSubstr("computes dx[1] as"));
    EXPECT_THAT(edited(prior, "t0 = sine(x[0])", "t0 = cosine(x[0])"), HasSubstr("computes dx[0] as"));
    EXPECT_THAT(edited(prior, "t2 = exponential(", "t2 = logarithm("), HasSubstr("computes y[0] as"));
    EXPECT_THAT(edited(computed, "0.5f * r[0] * r[4]", "0.5f * r[0] * r[5]"), HasSubstr("computes r[2] as"));
    EXPECT_THAT(edited(computed, "- 2.0f)", "- 2.0001f)"), HasSubstr("computes r[3] as"));
  }
}

/// What check_folding() says when `change` has been made to the folded numbers.
template <class Change>
std::string folded_otherwise(const Model& model, const Change& change, WeightType weights = WeightType::kFull) {
  const PreparedExport prepared(model, {.name = "", .weights = weights});
  FoldedModel folded = prepared.folded();
  change(folded);
  return thrown_message([&] {
    check_folding(model, folded, weights);
    return 0;
  });
}

TEST(ReadBackFields, NumbersThatAreFoldedOtherwiseAreSeen) {
  const auto map = [](FoldedModel& f) -> FoldedNetwork& { return f.networks.front(); };
  for (const Model& model : {rig_model(), commanded_model(), hold_model("rk4"), hold_model("zero_order")}) {
    SCOPED_TRACE(model.name);
    EXPECT_EQ(folded_otherwise(model, [](FoldedModel&) {}), "no error");
    EXPECT_THAT(folded_otherwise(model, [&](FoldedModel& f) { map(f).layers[0].weights(1, 1) *= 1.0 + 1e-9; }),
                HasSubstr("inverse_map.layers[0].weights[1][1] is "));
    EXPECT_THAT(folded_otherwise(model, [&](FoldedModel& f) { map(f).layers[0].bias(1) += 1e-9; }),
                HasSubstr("inverse_map.layers[0].bias[1] is "));
    EXPECT_THAT(folded_otherwise(model, [&](FoldedModel& f) { map(f).layers.pop_back(); }),
                HasSubstr("layers when folded"));
    EXPECT_THAT(folded_otherwise(model, [&](FoldedModel& f) { map(f).layers.back().weights *= 1.5; }),
                HasSubstr(".weights[0][0] is "));  // as an output scale that is taken twice
    EXPECT_THAT(folded_otherwise(model, [&](FoldedModel& f) { map(f).layers[0].weights.transposeInPlace(); }),
                HasSubstr("when folded, and the model's"));
    EXPECT_THAT(folded_otherwise(model, [](FoldedModel& f) { f.step.a_minus_1(0) *= 1.0 + 1e-9; }),
                HasSubstr("A - I[0]"));
    EXPECT_THAT(folded_otherwise(model, [](FoldedModel& f) { f.step.b0(0, 0) *= 1.0 + 1e-9; }), HasSubstr("B0[0]"));
    EXPECT_THAT(folded_otherwise(model, [](FoldedModel& f) { f.step.b1(0, 0) += 1e-9; }), HasSubstr("B1[0]"));
    EXPECT_THAT(folded_otherwise(model, [](FoldedModel& f) { f.steady_gain(0, 0) *= 1.0 + 1e-9; }), HasSubstr("S[0]"));
  }
  EXPECT_THAT(folded_otherwise(rig_model(), [&](FoldedModel& f) { map(f).linear_path(0, 1) *= 1.0 + 1e-9; }),
              HasSubstr("inverse_map.skip[0][1]"));
  const auto by = [&](double factor) {
    return [&, factor](FoldedModel& f) { map(f).layers[0].weights(0, 0) *= factor; };
  };
  EXPECT_EQ(folded_otherwise(rig_model(), by(1.0), WeightType::kBfloat16), "no error");
  EXPECT_THAT(folded_otherwise(rig_model(), by(1.01), WeightType::kBfloat16), HasSubstr("weights[0][0]"));
}

}  // namespace
}  // namespace nlo::codegen
