// SPDX-License-Identifier: MIT
#include "trainer/base/noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "codegen/base/error.h"
#include "trainer/base/noise_table.h"
#include "trainer/base/number_text.h"

namespace nlo::trainer {
namespace {

std::string forms() {
  std::string text = "write ";
  for (const NoiseRow& row : noise_table())
    text += fmt::format("{}{}{}",
                        &row == &noise_table().front()  ? ""
                        : &row == &noise_table().back() ? " or "
                                                        : ", ",
                        row.name, row.numbers);
  return text +
         ", followed by any of +outliers:SHARE:AMPLITUDE, +bias:HALF_WIDTH, +common_bias:HALF_WIDTH, "
         "+clipped:LIMIT, +quantised:STEP, +delay:SAMPLES or +delay:MINIMUM:MAXIMUM, +jitter:SHARE_OF_PERIOD, and "
         "+missing, "
         "+stuck or +dead with :SHARE or :SHARE:SAMPLES_IN_A_ROW";
}

/// A property with a single number, such as bias:0.2.
struct OneNumber {
  std::string_view word;
  double SensorNoise::*number;
};
constexpr std::array<OneNumber, 4> kOneNumber = {{{"bias", &SensorNoise::bias},
                                                  {"common_bias", &SensorNoise::common_bias},
                                                  {"clipped", &SensorNoise::limit},
                                                  {"quantised", &SensorNoise::quantum}}};

constexpr int kLongestDelay = 10000;  // samples; a longer delay is taken for a mistake

std::vector<std::string_view> split(std::string_view text, char at) {
  std::vector<std::string_view> parts;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find(at, start), text.size());
    parts.push_back(text.substr(start, end - start));
    start = end + 1;
  }
  return parts;
}

/// One of the parts between plus signs: a word and its numbers.
class Part {
 public:
  Part(std::string_view text, std::string_view all) : words_(split(text, ':')), all_(all) {}

  std::string_view word() const { return words_.front(); }

  [[noreturn]] void fail(std::string_view what) const {
    throw codegen::Error(fmt::format("noise \"{}\" {}; {}", all_, what, forms()));
  }

  /// Returns number `index`, which must not be negative.
  double number(std::size_t index) const {
    if (words_.size() <= index) fail("has no scale");
    const auto value = finite_number(words_[index]);
    if (!value) fail("has a scale that is not a number");
    if (*value < 0.0) fail("has a negative scale");
    return *value;
  }

  bool has(std::size_t index) const { return words_.size() > index; }

  void expect(std::size_t numbers) const {
    if (words_.size() > numbers + 1) fail("has one number too many");
  }

 private:
  std::vector<std::string_view> words_;
  std::string_view all_;
};

void add_outage(const Part& part, OutageRate& rate) {
  rate.share = part.number(1);
  if (rate.share >= 1.0) part.fail(fmt::format("has all samples {}", part.word()));
  if (part.has(2)) {
    rate.samples = part.number(2);
    if (rate.samples < 1.0) part.fail(fmt::format("has less than one sample {} in a row", part.word()));
    if (outage_odds(rate).begins > 1.0)
      part.fail(
          fmt::format("has more {} samples than bursts of this length allow; make the bursts longer", part.word()));
  }
  part.expect(2);
}

void add_fault(const Part& part, SensorNoise& noise) {
  for (const OneNumber& each : kOneNumber) {
    if (part.word() != each.word) continue;
    noise.*each.number = part.number(1);
    return part.expect(1);
  }
  for (const OutageKind kind : kOutageKinds)
    if (part.word() == outage_word(kind)) return add_outage(part, noise.outage(kind));
  if (part.word() == "outliers") {
    noise.outlier_share = part.number(1);
    noise.outlier_amplitude = part.number(2);
    part.expect(2);
    if (noise.outlier_share > 1.0) part.fail("has outliers in a share of the samples that is above 1");
  } else if (part.word() == "delay") {
    noise.delay_low = noise.delay_high = part.number(1);
    if (part.has(2)) noise.delay_high = part.number(2);
    part.expect(2);
    if (noise.delay_low > noise.delay_high) part.fail("has a minimum delay above its maximum: swap them");
    if (noise.delay_high > kLongestDelay) part.fail(fmt::format("has a delay above {} samples", kLongestDelay));
  } else if (part.word() == "jitter") {
    noise.jitter = part.number(1);
    part.expect(1);
    if (noise.jitter > 0.5) part.fail("has a jitter above half a sample period, so that samples would change places");
  } else {
    part.fail(fmt::format("has an unknown word after a plus, \"{}\"", part.word()));
  }
}

SensorNoise parse_sensor(std::string_view text) {
  const std::vector<std::string_view> parts = split(text, '+');
  const Part base(parts.front(), text);
  const auto row = std::ranges::find(noise_table(), base.word(), &NoiseRow::name);
  if (row == noise_table().end()) base.fail("is of an unknown kind");
  SensorNoise noise;
  noise.kind = row->kind;
  if (row->has_scale()) noise.scale = base.number(1);
  if (row->has_shape()) {
    const double shape = base.number(2);
    if (!(shape >= row->least_shape && shape <= row->most_shape) || shape != std::floor(shape))
      base.fail(fmt::format("needs an integer from {} to {} after its scale", row->least_shape, row->most_shape));
    noise.shape = static_cast<int>(shape);
  }
  base.expect((row->has_scale() ? 1U : 0U) + (row->has_shape() ? 1U : 0U));
  for (std::size_t i = 1; i < parts.size(); ++i) add_fault(Part(parts[i], text), noise);
  return noise;
}

}  // namespace

std::string_view outage_word(OutageKind kind) {
  constexpr std::array<std::string_view, kOutageKinds.size()> kWords = {"missing", "stuck", "dead"};
  return kWords[static_cast<std::size_t>(kind)];
}

bool SensorNoise::has_tails() const {
  return noise_row(kind).tails || outlier_share > 0.0;
}

bool SensorNoise::lies() const {
  return outage(OutageKind::kStuck).share > 0.0 || outage(OutageKind::kDead).share > 0.0 || limit > 0.0;
}

bool NoiseConfig::none() const {
  return std::all_of(sensors.begin(), sensors.end(), [](const auto& noise) { return noise.none(); });
}

bool NoiseConfig::shifted() const {
  return std::any_of(sensors.begin(), sensors.end(), [](const auto& noise) { return noise.shifted(); });
}

bool NoiseConfig::fails() const {
  return std::any_of(sensors.begin(), sensors.end(), [](const auto& noise) { return noise.fails(); });
}

OutageOdds outage_odds(const OutageRate& rate) {
  if (rate.samples == 0.0) return {rate.share, rate.share};
  return {1.0 - 1.0 / rate.samples, rate.share / ((1.0 - rate.share) * rate.samples)};
}

NoiseConfig parse_noise(std::string_view text) {
  NoiseConfig noise;
  noise.sensors.clear();
  for (const std::string_view sensor : split(text, ',')) noise.sensors.push_back(parse_sensor(sensor));
  return noise;
}

std::string format_noise(const SensorNoise& noise) {
  const NoiseRow& row = noise_row(noise.kind);
  std::string text(row.name);
  if (row.has_scale()) text += ":" + shortest_text(noise.scale);
  if (row.has_shape()) text += fmt::format(":{}", noise.shape);
  if (noise.outlier_share > 0.0)
    text += "+outliers:" + shortest_text(noise.outlier_share) + ":" + shortest_text(noise.outlier_amplitude);
  for (const OneNumber& each : kOneNumber)
    if (noise.*each.number > 0.0) text += fmt::format("+{}:{}", each.word, shortest_text(noise.*each.number));
  if (noise.delayed()) text += "+delay:" + shortest_text(noise.delay_low);
  if (noise.delay_low < noise.delay_high) text += ":" + shortest_text(noise.delay_high);
  if (noise.jitter > 0.0) text += "+jitter:" + shortest_text(noise.jitter);
  for (const OutageKind kind : kOutageKinds) {
    const auto& [share, samples] = noise.outage(kind);
    if (share > 0.0) text += fmt::format("+{}:{}", outage_word(kind), shortest_text(share));
    if (share > 0.0 && samples > 0.0) text += ":" + shortest_text(samples);
  }
  return text;
}

std::string format_noise(const NoiseConfig& noise) {
  std::string text;
  for (const SensorNoise& sensor : noise.sensors) text += (text.empty() ? "" : ",") + format_noise(sensor);
  return text;
}

void check_noise(const NoiseConfig& noise, std::size_t outputs) {
  if (noise.sensors.size() == 1 || noise.sensors.size() == outputs) return;
  throw codegen::Error(
      fmt::format("noise \"{}\" is for {} outputs, but there {} {}; give one for all of them, or one for "
                  "each (\"none\" where there is none)",
                  format_noise(noise), noise.sensors.size(), outputs == 1 ? "is" : "are", outputs));
}

}  // namespace nlo::trainer
