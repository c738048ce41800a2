// SPDX-License-Identifier: MIT
#include "trainer/data/zero_phase_filter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "codegen/base/error.h"

namespace nlo::trainer {
namespace {

using codegen::Error;

/// Filters in place, in transposed direct form II. It starts in the steady state of the first sample, so that a
/// constant has no transient.
void filter_in_place(const FilterSection& s, Eigen::Ref<Eigen::VectorXd> x) {
  const double gain = (s.b0 + s.b1 + s.b2) / (1.0 + s.a1 + s.a2);
  double second = (s.b2 - s.a2 * gain) * x[0];
  double first = (s.b1 - s.a1 * gain) * x[0] + second;
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const double y = s.b0 * x[k] + first;
    first = s.b1 * x[k] - s.a1 * y + second;
    second = s.b2 * x[k] - s.a2 * y;
    x[k] = y;
  }
}

Eigen::Index extension_length(const std::vector<FilterSection>& sections) {
  Eigen::Index order = 0;
  for (const FilterSection& s : sections) order += s.a2 == 0.0 ? 1 : 2;
  return 3 * (order + 1);
}

}  // namespace

std::vector<FilterSection> butterworth_lowpass(int order, double cutoff_hz, double sample_rate_hz) {
  if (order < 1 || order > 8) throw Error(fmt::format("velocity filter: order = {}: expected 1 to 8", order));
  if (!(cutoff_hz > 0.0 && cutoff_hz < 0.5 * sample_rate_hz))
    throw Error(
        fmt::format("velocity filter: cutoff_hz = {}: expected more than 0 and less than half the sample rate, {} Hz",
                    cutoff_hz, 0.5 * sample_rate_hz));
  // Analogue prototype 1 / (s^2 + s/Q + 1) per pole pair, s = (1/K) (1 - z^-1) / (1 + z^-1), K prewarped.
  const double K = std::tan(std::numbers::pi * cutoff_hz / sample_rate_hz);
  std::vector<FilterSection> sections;
  for (int pair = 0; pair < order / 2; ++pair) {
    const double inverse_Q = 2.0 * std::sin(std::numbers::pi * (2 * pair + 1) / (2.0 * order));
    const double norm = 1.0 / (1.0 + K * inverse_Q + K * K);
    const double b = K * K * norm;
    sections.push_back({b, 2.0 * b, b, 2.0 * (K * K - 1.0) * norm, (1.0 - K * inverse_Q + K * K) * norm});
  }
  if (order % 2 == 1) sections.push_back({K / (K + 1.0), K / (K + 1.0), 0.0, (K - 1.0) / (K + 1.0), 0.0});
  return sections;
}

Eigen::VectorXd filter_zero_phase(const std::vector<FilterSection>& sections, const Eigen::VectorXd& x) {
  const Eigen::Index n = x.size(), pad = extension_length(sections);
  if (n <= pad)
    throw Error(
        fmt::format("velocity filter: {} samples are too few, because this order needs more than {}: use a longer log "
                    "or a lower order",
                    n, pad));
  Eigen::VectorXd y(n + 2 * pad);
  y.segment(pad, n) = x;
  y.head(pad) = 2.0 * x[0] - x.segment(1, pad).reverse().array();
  y.tail(pad) = 2.0 * x[n - 1] - x.segment(n - 1 - pad, pad).reverse().array();
  for (int pass = 0; pass < 2; ++pass) {
    for (const FilterSection& section : sections) filter_in_place(section, y);
    y.reverseInPlace();
  }
  return y.segment(pad, n);
}

Eigen::VectorXd central_difference(const Eigen::VectorXd& x, double h) {
  const Eigen::Index n = x.size();
  Eigen::VectorXd slope(n);
  slope[0] = (x[1] - x[0]) / h;
  slope[n - 1] = (x[n - 1] - x[n - 2]) / h;
  slope.segment(1, n - 2) = (x.tail(n - 2) - x.head(n - 2)) / (2.0 * h);
  return slope;
}

Eigen::VectorXd interpolate(const Eigen::VectorXd& time, const Eigen::VectorXd& x, const Eigen::VectorXd& at) {
  Eigen::VectorXd result(at.size());
  for (Eigen::Index k = 0; k < at.size(); ++k) {
    const auto right = std::upper_bound(time.begin(), time.end(), at[k]) - time.begin();
    if (right == 0 || right == time.size()) {
      result[k] = right == 0 ? x[0] : x[x.size() - 1];
      continue;
    }
    const double share = (at[k] - time[right - 1]) / (time[right] - time[right - 1]);
    result[k] = x[right - 1] + share * (x[right] - x[right - 1]);
  }
  return result;
}

Eigen::VectorXd zero_phase_velocity(const VelocityFilterConfig& config, const Eigen::VectorXd& time_s,
                                    const Eigen::VectorXd& position, double sample_period_s) {
  const double start = time_s[0], duration = time_s[time_s.size() - 1] - start;
  // The grid ends at the last sample. Its step equals the nominal one to within half a step over the whole log.
  const auto steps = static_cast<Eigen::Index>(std::max(1.0, std::round(duration / sample_period_s)));
  const double h = duration / static_cast<double>(steps);
  const Eigen::VectorXd grid = Eigen::VectorXd::LinSpaced(steps + 1, start, start + duration);
  const auto sections = butterworth_lowpass(config.order, config.cutoff_hz, 1.0 / h);
  const Eigen::VectorXd smooth = filter_zero_phase(sections, interpolate(time_s, position, grid));
  return interpolate(grid, central_difference(smooth, h), time_s);
}

}  // namespace nlo::trainer
