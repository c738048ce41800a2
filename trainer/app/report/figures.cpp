// SPDX-License-Identifier: MIT
#include "trainer/app/report/figures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "trainer/data/measurement_noise.h"
#include "trainer/judge/evaluation/estimator_words.h"

namespace nlo::trainer {
namespace {

using Style = Series::Style;

std::string subscript(std::size_t number) {
  std::string text;
  for (const char digit : std::to_string(number))
    text += fmt::format("\xe2\x82{}", static_cast<char>(0x80 + digit - '0'));
  return text;
}

bool any_finite(const Eigen::VectorXd& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

/// Describes the knowledge that an estimator has and an observer lacks.
std::string filter_in_words(const std::string& estimator) {
  const EstimatorWords* words = estimator_words(estimator);
  return words == nullptr || !words->knows_plant
             ? estimator
             : fmt::format("the {}, which knows the plant and the noise exactly", words->meaning);
}

}  // namespace

Figure training_figure(const TrainingCurves& curves) {
  Figure figure{
      "Left: the training loss. Right: root mean square error of the estimate on validation data.", 960, 260, true, {}};
  Panel loss{"step", "training loss", false, true, false, false, 0, 0, 0, 0, {}};
  loss.series.push_back({"", Style::kLine, 0, thinned(curves.step), thinned(curves.loss), {}});
  Panel rmse{"step", "RMSE", false, true, false, false, 0, 0, 0, 0, {}};
  if (any_finite(curves.train_rmse)) {
    figure.caption =
        "Left: the training loss. Right: root mean square error of the estimate on training and on validation data.";
    rmse.series.push_back({"training", Style::kThinLine, 5, thinned(curves.step), thinned(curves.train_rmse), {}});
  }
  rmse.series.push_back({"validation", Style::kLine, 1, thinned(curves.step), thinned(curves.validation_rmse), {}});
  figure.panels = {std::move(loss), std::move(rmse)};
  return figure;
}

Figure eigenvalue_figure(const TrainingCurves& curves) {
  Figure figure{
      "Eigenvalues of the latent system D over the training: how fast the observer forgets.", 960, 260, true, {}};
  Panel re{"step", "real part [1/s]", false, false, false, false, 0, 0, 0, 0, {}};
  Panel im{"step", "imaginary part [rad/s]", false, false, false, false, 0, 0, 0, 0, {}};
  for (std::size_t i = 0; i < curves.eigenvalues.size(); ++i) {
    const Eigen::VectorXd imaginary = curves.eigenvalues[i].imag();
    const std::string name = fmt::format("λ{}", subscript(i + 1));
    const auto colour = static_cast<int>(i);
    re.series.push_back({name, Style::kLine, colour, thinned(curves.step), thinned(curves.eigenvalues[i].real()), {}});
    if (imaginary.cwiseAbs().maxCoeff() > 0.0)
      im.series.push_back({name, Style::kLine, colour, thinned(curves.step), thinned(imaginary), {}});
  }
  figure.panels = {std::move(re)};
  if (!im.series.empty()) {
    figure.panels.push_back(std::move(im));
    figure.caption =
        "Eigenvalues of the latent system D over the training: how fast the observer forgets, and to which frequency "
        "it responds. A complex pair is drawn once.";
  }
  return figure;
}

Figure eigenvalue_map(const TrainingCurves& curves) {
  Figure figure{"Eigenvalues in the complex plane, from where they started (crosses) to where they ended (dots).",
                620,
                380,
                false,
                {}};
  Panel map{"real part [1/s]", "imaginary part [rad/s]", false, false, true, true, 0, 0, 0, 0, {}};
  double reach = 0.0, height = 0.0;
  for (std::size_t i = 0; i < curves.eigenvalues.size(); ++i) {
    const Eigen::VectorXd re = curves.eigenvalues[i].real(), im = curves.eigenvalues[i].imag();
    const auto colour = static_cast<int>(i);
    reach = std::max(reach, -re.minCoeff());
    height = std::max(height, im.cwiseAbs().maxCoeff());
    for (const double sign : {1.0, -1.0}) {
      if (sign < 0.0 && im.cwiseAbs().maxCoeff() == 0.0) continue;
      const std::string name = sign > 0.0 ? fmt::format("λ{}", subscript(i + 1)) : "";
      map.series.push_back({"", Style::kThinLine, colour, thinned(re), thinned(sign * im), {}});
      map.series.push_back({"", Style::kCrosses, colour, re.head(1), sign * im.head(1), {}});
      map.series.push_back({name, Style::kPoints, colour, re.tail(1), sign * im.tail(1), {}});
    }
  }
  // Leaves room to the right of the imaginary axis, so that the border of stability is visible.
  map.x_low = -1.1 * std::max(reach, 1e-6);
  map.x_high = 0.08 * std::max(reach, 1e-6);
  const double half_height = height > 0.0 ? 1.2 * height : 1.0;
  map.y_low = -half_height;
  map.y_high = half_height;
  figure.panels = {std::move(map)};
  return figure;
}

Figure error_figure(const std::vector<StudyRow>& rows) {
  Figure figure{"Error over time, root mean square over the test set.", 960, 330, false, {}};
  const std::vector<Channel>& states = rows.front().observer().first().states;
  for (const Channel& state : states)
    if (state.unit != states.front().unit) return figure;
  Panel panel{"time [s]", "error norm", false, true, false, false, 0, 0, 0, 0, {}};
  double low = 1e300, high = 0.0;
  std::vector<std::string> dashed;
  for (std::size_t g = 0; g < rows.size(); ++g) {
    std::size_t colour = g;  // the observer and its first alternative have this colour
    for (const StudyCell& cell : rows[g].cells) {
      const Evaluation& evaluation = cell.first();
      // The errors of these baselines are far larger and would compress the other lines.
      if (evaluation.estimator == "constant" || evaluation.estimator == "ridge") continue;
      const bool ours = &cell == &rows[g].observer();
      const ErrorMetrics& m = evaluation.metrics;
      panel.series.push_back({fmt::format("{}, {}", evaluation.estimator, noise_title(evaluation.noise)),
                              ours ? Style::kLine : Style::kDashes,
                              static_cast<int>(colour),
                              thinned(m.curve_time_s),
                              thinned(m.curve),
                              {}});
      if (!ours) colour += rows.size();
      if (const std::string name = filter_in_words(evaluation.estimator);
          !ours && std::find(dashed.begin(), dashed.end(), name) == dashed.end())
        dashed.push_back(name);
      high = std::max(high, m.curve.maxCoeff());
      low = std::min(low, m.curve.minCoeff());
    }
  }
  // An exact model without noise falls to 1e-8, which would compress the visible part of the plot.
  if (high > 0.0 && low < high) {
    panel.y_low = 0.7 * std::max(low, 2e-3 * high);
    panel.y_high = 1.5 * high;
  }
  if (!dashed.empty()) figure.caption += fmt::format(" Dashed: {}.", fmt::join(dashed, "; "));
  figure.panels = {std::move(panel)};
  return figure;
}

Figure latency_figure(const ControlLoopResult& result) {
  Figure figure{
      "How long one step and estimate took in the control loop; both axes are logarithmic.", 960, 280, false, {}};
  Panel panel{"step + estimate [ns]", "ticks", true, true, false, false, 0, 0, 0, 0, {}};
  const auto n = static_cast<Eigen::Index>(result.histogram.size());
  Eigen::VectorXd x(n), y(n), width(n);
  double highest = 1.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& bucket = result.histogram[static_cast<std::size_t>(i)];
    constexpr double kGrowth = 1.25;  // ratio of the limits of neighbouring buckets
    const double lower = bucket.below_ns / kGrowth;
    x[i] = 0.5 * (lower + bucket.below_ns);
    width[i] = 0.96 * (bucket.below_ns - lower);
    y[i] = bucket.count;
    highest = std::max(highest, bucket.count);
  }
  if (n > 0) {
    panel.x_low = result.histogram.front().below_ns / 2.0;
    panel.x_high = result.histogram.back().below_ns * 1.5;
  }
  panel.y_low = 0.5;
  panel.y_high = 2.0 * highest;
  panel.series.push_back({"", Style::kBars, 0, x, y, width});
  figure.panels = {std::move(panel)};
  return figure;
}

}  // namespace nlo::trainer
