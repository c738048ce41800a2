// SPDX-License-Identifier: MIT
// Exports are read back and compared with their models. Each control breaks one thing in a text that is right.
#include "codegen/readback/read_back.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/base/zip.h"
#include "codegen/model_file/model_file.h"
#include "codegen/readback/wrappers.h"
#include "codegen/structures/module.h"
#include "codegen/targets/generated.h"
#include "tests/codegen/readback_text.h"

namespace nlo::codegen {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::vector<std::string> values_of(const ReadConstant& c) {
  std::vector<std::string> values;
  for (const ReadValue& value : c.values) values.push_back(value.text);
  return values;
}

bool is_number(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789.ef+-") == std::string::npos && text != "e" && text != "f";
}

/// One digit is another, the last that makes it another number.
std::string with_another_digit(const std::string& text) {
  const bool single = text.ends_with('f');
  const auto number = [&](const std::string& t) {
    return single ? static_cast<double>(std::strtof(t.c_str(), nullptr)) : std::strtod(t.c_str(), nullptr);
  };
  for (std::size_t at = std::min(text.find('e'), text.size()); at-- > 0;) {
    if (text[at] < '0' || text[at] > '9') continue;
    std::string changed = text;
    changed[at] = text[at] == '9' ? '8' : static_cast<char>(text[at] + 1);
    if (number(changed) != number(text)) return changed;
  }
  return text;
}

/// Row by row what stood column by column.
std::vector<std::string> transposed(const ReadConstant& c) {
  const std::size_t rows = c.shape[0], columns = c.shape[1];
  std::vector<std::string> values;
  for (std::size_t i = 0; i < rows * columns; ++i) values.push_back(c.values[i % rows * columns + i / rows].text);
  return values;
}

/// Without what declares it.
std::string without(const Text& t, const ReadConstant& c) {
  const std::size_t first = c.values.front().at, last = c.values.back().at + c.values.back().text.size();
  const std::string leaf = c.path.substr(c.path.rfind('.') + 1);
  std::string changed = t.text;
  if (t.form == TextForm::kCpp) {
    const std::size_t start = changed.rfind("." + leaf + " =", first);
    std::size_t end = last;
    for (std::size_t depth = c.shape.size(); depth > 0; ++end) depth -= changed[end] == '}' ? 1 : 0;
    return changed.erase(start, end + (changed[end] == ',' ? 1 : 0) - start);
  }
  const std::size_t start = changed.rfind('\n', changed.rfind("const", first));
  return changed.erase(start, changed.find(';', last) + 1 - start);
}

template <class Check>
void for_each_text(const std::vector<Model>& models, const Check& check) {
  for (const Model& model : models)
    for (const Form& form : kForms)
      for (const ScalarType scalar : {ScalarType::kFloat, ScalarType::kDouble, ScalarType::kInt16}) {
        if (scalar == ScalarType::kInt16 && !module_of(model).abilities().int16) continue;
        const Text text(model, {.name = "", .scalar = scalar}, form);
        SCOPED_TRACE(text.what);
        check(text);
      }
}

TEST(ReadBack, EveryExportSaysItsModel) {
  for_each_text(models_of_structures(), [](const Text& t) { EXPECT_EQ(t.refusal(t.text), "no error"); });
  for (const Model& model : example_models())
    for (const Form& form : kForms)
      EXPECT_NO_THROW(generated(export_target(form.target), PreparedExport(model))) << model.name << form.target;
  for (const auto& entry : std::filesystem::directory_iterator(NLO_SOURCE_DIR "/examples/models")) {
    const PreparedExport shipped(read_model(entry.path().string()));
    for (const ExportTarget& target : export_targets()) {
      if (target.name == "fmu" || target.roles) continue;  // asks for a compiler, or which channels are what
      EXPECT_NO_THROW(generated(target, shipped)) << entry << target.name;
    }
  }
  for (const Model& model : {large_model(), mixed_model()})  // laid out as panels
    for (const WeightType weights : {WeightType::kFull, WeightType::kBfloat16, WeightType::kFloat16})
      EXPECT_NO_THROW(generated(export_target("cpp"), PreparedExport(model, {.name = "", .weights = weights})));
}

/// A digit of the last layer's last bias is another in each text of it.
std::vector<NamedText> spoilt(const std::vector<NamedText>& files, const std::string& text) {
  std::vector<NamedText> changed = files;
  for (NamedText& file : changed)
    for (std::size_t at = 0; (at = file.text.find(text, at)) != std::string::npos; at += text.size())
      file.text[at + text.size() - 2] = file.text[at + text.size() - 2] == '9' ? '8' : '9';
  return changed;
}

TEST(ReadBack, LooksIntoEveryFormOfExport) {
  const std::string bias = "0.5261358f";
  for (ExportTarget target : export_targets()) {
    if (target.name == "fmu" || target.roles) continue;  // asks for a compiler, or which channels are what
    EXPECT_NO_THROW(generated(target, PreparedExport(tiny_model()))) << target.name;
    const auto right = target.generate;
    target.generate = [&](const PreparedExport& prepared) {
      const std::vector<NamedText> files = right(prepared);
      if (target.name != "fmu-sources") return spoilt(files, bias);
      return std::vector<NamedText>{{files[0].path, zip(spoilt(unzipped(files[0].text), bias))}};
    };
    EXPECT_THAT(thrown_message([&] { return generated(target, PreparedExport(tiny_model())); }),
                target.no_observer ? HasSubstr("no error") : HasSubstr("must be 0.5261358f"))
        << target.name;
    target.generate = [](const PreparedExport&) { return std::vector<NamedText>{{"README.md", "no observer"}}; };
    EXPECT_EQ(thrown_message([&] { return generated(target, PreparedExport(tiny_model())); }) == "no error",
              target.no_observer);
  }
}

TEST(ReadBack, ASensorForSimpleFocIsRight) {
  EXPECT_NO_THROW(generated(export_target("simplefoc"), PreparedExport(watched_rig_model())));
}

TEST(ReadBack, WrappersNameThePeriodAndTheSizesOfTheirModel) {
  int files = 0;
  for (const ExportTarget& target : export_targets()) {
    if (target.name == "fmu" || target.roles) continue;
    const Model model = commanded_model();
    std::vector<NamedText> right = target.generate(PreparedExport(model));
    if (target.name == "fmu-sources") right = unzipped(right.front().text);
    EXPECT_NO_THROW(check_wrappers(model, right)) << target.name;
    for (const std::string_view place :
         {"kPeriod = ", "kPeriod_us = ", "kStatus = kEstimate + ", "stepSize=\"", "ssSetSampleTime(S, 0, ",
          "kStates = ", "ssSetInputPortWidth(S, kKnown, ", "variability=\"fixed\" start=\""})
      for (std::size_t i = 0; i < right.size(); ++i) {
        const std::size_t at = right[i].text.find(place);
        if (at == std::string::npos || right[i].path.find("nlo/") != std::string::npos) continue;
        std::vector<NamedText> changed = right;
        char& digit = changed[i].text[at + place.size()];
        digit = digit == '7' ? '8' : '7';
        EXPECT_THAT(thrown_message([&] {
                      check_wrappers(model, changed);
                      return 0;
                    }),
                    AllOf(HasSubstr(right[i].path + ":"), HasSubstr(std::string(place))))
            << target.name;
        ++files;
      }
  }
  EXPECT_GT(files, 8);
}

TEST(ReadBack, OneDigitOfEachConstantIsSeen) {
  for_each_text(models_of_structures(), [](const Text& t) {
    int numbers = 0;
    for (const ReadConstant& c : t.constants) {
      const std::size_t i = c.values.size() / 2;
      if (c.values.empty() || !is_number(c.values[i].text)) continue;
      std::vector<std::string> values = values_of(c);
      values[i] = with_another_digit(values[i]);
      if (t.text.compare(c.values[i].at, c.values[i].text.size(), c.values[i].text) != 0) continue;  // an enumerator
      EXPECT_THAT(t.refusal(t.with_values(c, values)),
                  AllOf(HasSubstr(c.path), HasSubstr(values[i]), HasSubstr("must be ")));
      ++numbers;
    }
    EXPECT_GT(numbers, 10);
  });
}

TEST(ReadBack, ATransposedMatrixIsSeen) {
  for_each_text(models_of_structures(), [](const Text& t) {
    for (const ReadConstant& c : t.constants) {
      if (c.shape.size() != 2 || transposed(c) == values_of(c)) continue;
      EXPECT_THAT(t.refusal(t.with_values(c, transposed(c))), HasSubstr(c.path));
    }
  });
}

TEST(ReadBack, AnArrayThatIsNotThereIsSeen) {
  for_each_text(models_of_structures(), [](const Text& t) {
    for (const ReadConstant& c : t.constants) {
      const bool field_of_c99 = t.form != TextForm::kCpp && c.path.starts_with("kStep.");
      if (c.shape.empty() || field_of_c99 || !is_number(c.values[0].text)) continue;
      EXPECT_THAT(t.refusal(without(t, c)), AllOf(HasSubstr(c.path + " is not there")));
    }
  });
}

TEST(ReadBack, TwoArraysThatHaveChangedPlacesAreSeen) {
  for_each_text(models_of_structures(), [](const Text& t) {
    int pairs = 0;
    for (std::size_t i = 0; i < t.constants.size(); ++i)
      for (std::size_t j = i + 1; j < t.constants.size(); ++j) {
        const ReadConstant &a = t.constants[i], &b = t.constants[j];
        if (a.shape.empty() || a.shape != b.shape || values_of(a) == values_of(b)) continue;
        if (!is_number(a.values[0].text) || !is_number(b.values[0].text)) continue;
        std::string changed = t.text;  // b stands behind a
        for (std::size_t k = b.values.size(); k-- > 0;)
          changed.replace(b.values[k].at, b.values[k].text.size(), a.values[k].text);
        for (std::size_t k = a.values.size(); k-- > 0;)
          changed.replace(a.values[k].at, a.values[k].text.size(), b.values[k].text);
        EXPECT_THAT(t.refusal(changed), testing::AnyOf(HasSubstr(a.path), HasSubstr(b.path)));
        ++pairs;
      }
    EXPECT_GT(pairs, 0);
  });
}

TEST(ReadBack, AConstantThatNothingExplainsIsSeen) {
  const Text t(tiny_model(), {}, kForms[1]);
  EXPECT_THAT(t.refusal(t.text + "static const Scalar kMore[2] = {1.0f, 2.0f};\n"),
              AllOf(HasSubstr("kMore is 1.0f"), HasSubstr("nothing of the model explains it")));
}

TEST(ReadBack, ALayerThatIsNotEvaluatedIsSeen) {
  const Text t(rig_model(), {}, kForms[1]);
  const std::size_t at = t.text.find("  tanh_layer(32, 24");
  std::string changed = t.text;
  changed.erase(at, changed.find('\n', at) - at);
  EXPECT_THAT(t.refusal(changed),
              AllOf(HasSubstr("estimate#2 is dense"), HasSubstr("must be tanh_layer 32 24 kWeights2")));
}

TEST(ReadBack, AnotherModelsTextIsSeen) {
  const Text t(rig_model(), {}, kForms[0]);
  Model other = rig_model();
  other.output_max(1) += 1e-6;
  EXPECT_THAT(thrown_message([&] {
                check_text(PreparedExport(other), t.form, {{"rig.h", t.text}});
                return 0;
              }),
              AllOf(HasSubstr("rig.h:"), HasSubstr("kModel.outputs.max[1] is 5.0f"), HasSubstr("5.000001f")));
}

}  // namespace
}  // namespace nlo::codegen
