// SPDX-License-Identifier: MIT
#include "codegen/readback/wrappers.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

#include "codegen/base/fail.h"

namespace nlo::codegen {
namespace {

/// In files of this ending, each number behind these words: one at least, unless the file may do without.
struct WrapperRow {
  std::string_view file, words;
  double value;
  bool always = true;
};

std::vector<WrapperRow> rows_of(const Model& m) {
  const double period = m.sample_period_s, period_us = std::clamp(std::round(period * 1e6), 1.0, 4e9);
  const double nx = m.nx(), measured = m.measured(), nu = m.nu();
  std::vector<WrapperRow> rows = {
      {"_fmi3_instance.h", "kPeriod = ", period},
      {"_fmi3_instance.h", "kInput = kReading + ", measured},
      {"_fmi3_instance.h", "kEstimate = kInput + ", nu},
      {"_fmi3_instance.h", "kStatus = kEstimate + ", nx},
      {"modelDescription.xml", "stepSize=\"", period},
      {"modelDescription.xml", "variability=\"constant\" start=\"", period},
      {"_sfun.c", "ssSetSampleTime(S, 0, ", period},
      {"_sfun.c", "widths[kOutputPorts] = {", nx},
      {"_sfun.c", "ssSetInputPortWidth(S, kMeasured, ", measured},
      {"_observer.cpp", "kPeriod_us = ", period_us},
      {"_sensor.h", "kPeriod_us = ", period_us},
      {".ino", "kPeriod_us = ", period_us, false},  // a Sensor of SimpleFOC has it in its header
      {"observer_controller.cpp", "kPeriod = ", period},
      {"observer_controller.cpp", "kMeasured = ", measured},
      {"observer_controller.cpp", "kInputs = ", nu},
      {"observer_controller.cpp", "kStates = ", nx},
  };
  if (m.nu() > 0) rows.push_back({"_sfun.c", "ssSetInputPortWidth(S, kKnown, ", nu});
  return rows;
}

int line_of(const std::string& text, std::size_t at) {
  return 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
}

/// The numbers behind `at` that blanks part.
std::vector<double> numbers_at(const std::string& text, std::size_t at) {
  std::vector<double> numbers;
  const char* end = text.data() + text.size();
  for (const char* from = text.data() + at; from < end;) {
    double number = 0.0;
    const auto [behind, error] = std::from_chars(from, end, number);
    if (error != std::errc()) break;
    numbers.push_back(number);
    if (behind == end || *behind != ' ') break;
    from = behind + 1;
  }
  return numbers;
}

[[noreturn]] void refuse(const NamedText& file, std::size_t at, std::string_view words, const std::string& value) {
  fail(
      "{}:{}: behind \"{}\" must stand {}; nothing is written: this is a fault of nlo, please report it with the model",
      file.path, line_of(file.text, at), words, value);
}

void check_initial(const Model& m, const NamedText& file) {
  const std::string words = "variability=\"fixed\" start=\"";
  const std::size_t at = file.text.find(words);
  const std::vector<double> initial(m.initial_latent.begin(), m.initial_latent.end());
  if (at == std::string::npos || numbers_at(file.text, at + words.size()) != initial)
    refuse(file, at == std::string::npos ? 0 : at, words, "initial_latent");
}

}  // namespace

void check_wrappers(const Model& m, const std::vector<NamedText>& files) {
  for (const NamedText& file : files) {
    for (const WrapperRow& row : rows_of(m)) {
      if (!file.path.ends_with(row.file)) continue;
      std::size_t at = file.text.find(row.words);
      if (at == std::string::npos && row.always) refuse(file, 0, row.words, fmt::format("{}", row.value));
      for (; at != std::string::npos; at = file.text.find(row.words, at + 1)) {
        const std::vector<double> numbers = numbers_at(file.text, at + row.words.size());
        if (numbers.empty() || numbers.front() != row.value) refuse(file, at, row.words, fmt::format("{}", row.value));
      }
    }
    if (file.path.ends_with("modelDescription.xml")) check_initial(m, file);
  }
}

}  // namespace nlo::codegen
