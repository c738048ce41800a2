// SPDX-License-Identifier: MIT
#include "trainer/data/logged_velocity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "trainer/data/angle.h"
#include "trainer/data/zero_phase_filter.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int kMaxLag = 20;            // a low-pass with a larger delay hardly resembles the velocity
constexpr Index kSamples = 20000;      // enough for a correlation; a log of a day need not be filtered whole
constexpr double kSameSignal = 0.9;    // two different states of a rig stay below it
constexpr double kLateSamples = 0.35;  // a backward difference is half a sample late; an exact velocity is not

struct Moments {
  double correlation = 0.0, gain = 0.0;
};

Moments correlate(const Eigen::Ref<const VectorXd>& signal, const Eigen::Ref<const VectorXd>& velocity) {
  const Eigen::ArrayXd s = signal.array() - signal.mean(), v = velocity.array() - velocity.mean();
  const double ss = s.square().sum(), vv = v.square().sum(), sv = (s * v).sum();
  if (!(ss > 0.0 && vv > 0.0)) return {};
  return {sv / std::sqrt(ss * vv), sv / vv};
}

std::string remark_on_gain(double gain) {
  constexpr double kDegrees = 180.0 / std::numbers::pi, kNear = 0.05;
  if (std::abs(std::abs(gain) / kDegrees - 1.0) < kNear)
    return "; it is 57.3 times as large, so it may be in degrees: check units";
  if (std::abs(std::abs(gain) * kDegrees - 1.0) < kNear)
    return "; it is 57.3 times smaller, so the angle may be in degrees: check units";
  return "";
}

}  // namespace

std::optional<VelocityMatch> match_velocity(const VectorXd& signal, const VectorXd& velocity, int max_lag) {
  const Index n = signal.size(), inner = n - 2 * max_lag;
  if (n < 10 * max_lag) return std::nullopt;
  // Every lag uses the same samples of the velocity. Otherwise the largest correlation would depend on the choice of
  // samples.
  std::vector<Moments> at;
  for (int lag = -max_lag; lag <= max_lag; ++lag)
    at.push_back(correlate(signal.segment(max_lag + lag, inner), velocity.segment(max_lag, inner)));
  const auto best = std::max_element(at.begin(), at.end(), [](const Moments& a, const Moments& b) {
    return std::abs(a.correlation) < std::abs(b.correlation);
  });
  if (best == at.begin() || best + 1 == at.end() || best->correlation == 0.0) return std::nullopt;
  // Near its maximum a correlation is a parabola, whose vertex gives the lag to a fraction of a sample.
  const double before = std::abs((best - 1)->correlation), top = std::abs(best->correlation),
               after = std::abs((best + 1)->correlation);
  const double curvature = before - 2.0 * top + after;
  const double fraction = curvature < 0.0 ? 0.5 * (before - after) / curvature : 0.0;
  return VelocityMatch{static_cast<double>(best - at.begin()) - max_lag + fraction, best->correlation, best->gain};
}

void note_logged_velocities(const LogSchema& schema, const VelocityFilterConfig& filter,
                            const std::vector<LogFile>& logs, const std::vector<std::vector<LogRun>>& runs,
                            double sample_period_s, std::vector<std::string>& notes) {
  const LogFile* log = nullptr;
  const LogRun* run = nullptr;
  for (std::size_t i = 0; i < logs.size(); ++i)
    for (const LogRun& candidate : runs[i])
      if (run == nullptr || candidate.rows > run->rows) {
        run = &candidate;
        log = &logs[i];
      }
  if (run == nullptr) return;
  VelocityFilterConfig usable = filter;  // the cut-off is for declared velocities; there may be none
  usable.cutoff_hz = std::min(filter.cutoff_hz, 0.2 / sample_period_s);
  const Index samples = std::min(run->rows, kSamples);
  if (samples < 10 * kMaxLag) return;
  const auto column = [&](const LogColumn& c) -> VectorXd {
    const VectorXd values = log->values(c).segment(run->first, samples);
    return c.wrap > 0.0 ? unwrap(values, c.wrap) : values;
  };
  std::vector<VectorXd> velocities;
  for (const LogColumn& output : schema.outputs)
    velocities.push_back(zero_phase_velocity(usable, run->time_s.head(samples), column(output), sample_period_s));
  for (const LogColumn& state : schema.states) {
    if (state.derivative || state.wrap > 0.0) continue;
    const VectorXd signal = column(state);
    // The joints of a rig move together, so the state belongs to the output that it resembles most.
    const LogColumn* source = nullptr;
    VelocityMatch match;
    for (std::size_t j = 0; j < velocities.size(); ++j) {
      if (schema.outputs[j].heading == state.heading) continue;
      const auto candidate = match_velocity(signal, velocities[j], kMaxLag);
      if (!candidate || std::abs(candidate->correlation) <= std::abs(match.correlation)) continue;
      match = *candidate;
      source = &schema.outputs[j];
    }
    if (source == nullptr || std::abs(match.correlation) < kSameSignal) continue;
    const std::string units = remark_on_gain(match.gain);
    const bool late = match.lag_samples > kLateSamples;
    if (!late && units.empty()) continue;
    notes.push_back(fmt::format(
        "{}: the logged state \"{}\" is the velocity of \"{}\"{} (correlation {:.3f}){}{}", log->name, state.heading,
        source->heading, late ? fmt::format(", {:.1f} samples late", match.lag_samples) : "",
        std::abs(match.correlation), units,
        late ? fmt::format(": an observer that learns this state is late, too; set derivative_of = \"{}\" for a truth "
                           "without one",
                           source->name)
             : ""));
  }
}

}  // namespace nlo::trainer
