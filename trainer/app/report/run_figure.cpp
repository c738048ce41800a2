// SPDX-License-Identifier: MIT
#include "trainer/app/report/run_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "trainer/app/report/thinning.h"
#include "trainer/judge/evaluation/metrics.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {
namespace {

using Style = Series::Style;
using Eigen::Index;
using Eigen::VectorXd;

constexpr int kTruth = 0, kEstimate = 1, kError = 4, kMeasured = 5, kInput = 6;
constexpr int kMasked = 5, kOutside = 3;  // bands
constexpr int kWidth = 960, kPanelHeight = 100;
constexpr double kLines = 860, kAround = 60;  // pixels: width of the axes, and additional height of a panel

/// Returns an angle as the sensor shows it; jumps become gaps in the line.
VectorXd wrapped(VectorXd values, double wrap) {
  if (wrap <= 0.0) return values;
  for (double& value : values) value = wrapped_difference(value, 0.0, wrap);
  for (Index i = values.size() - 1; i > 0; --i)
    if (std::abs(values[i] - values[i - 1]) > 0.5 * wrap) values[i] = std::nan("");
  return values;
}

/// Samples with t0 <= t <= t1.
struct Window {
  Index from = 0, count = 0;

  Window(const VectorXd& time_s, double t0, double t1)
      : from(std::lower_bound(time_s.begin(), time_s.end(), t0) - time_s.begin()),
        count(std::upper_bound(time_s.begin(), time_s.end(), t1) - time_s.begin() - from) {}
  VectorXd of(const VectorXd& values) const { return values.segment(from, count); }
};

/// Adds bands over the times at which `flagged` is true. Each extends half a step beyond its samples and is at least a
/// pixel wide; bands closer than that are joined.
void add_bands(std::vector<Band>& bands, const VectorXd& t, const Eigen::Array<bool, Eigen::Dynamic, 1>& flagged,
               int colour) {
  const Index n = t.size();
  const double pixel = (t[n - 1] - t[0]) / 800.0;
  const std::size_t first = bands.size();
  for (Index k = 0; k < n; ++k) {
    if (!flagged[k]) continue;
    const double from = k > 0 ? 0.5 * (t[k - 1] + t[k]) : t[k];
    const double to = k + 1 < n ? 0.5 * (t[k] + t[k + 1]) : t[k];
    if (bands.size() > first && from <= bands.back().to + pixel)
      bands.back().to = to;
    else
      bands.push_back({from, to, colour});
  }
  for (std::size_t i = first; i < bands.size(); ++i) bands[i].to = std::max(bands[i].to, bands[i].from + pixel);
}

std::vector<Band> bands_of(const EvaluatedRun& run, const Window& window, const VectorXd& t) {
  std::vector<Band> bands;
  const auto add = [&](const Eigen::Array<bool, Eigen::Dynamic, 1>& flagged, int colour, const char* title) {
    const std::size_t first = bands.size();
    add_bands(bands, t, flagged, colour);
    if (bands.size() > first) bands[first].title = title;
  };
  add(window.of(run.truth.weight).array() <= 0.0, kMasked, "not scored");
  if (run.outside.size() > 0) add(window.of(run.outside).array() > 0.0, kOutside, "outside of the training domain");
  return bands;
}

VectorXd error_of(const EvaluatedRun& run, Index state, double wrap) {
  VectorXd error(run.truth.samples());
  for (Index k = 0; k < error.size(); ++k)
    error[k] = -wrapped_difference(run.truth.states(state, k), run.estimate(state, k), wrap);
  return error;
}

/// Returns a panel without numbers below it, with a height of `height` panels.
Panel time_panel(const std::string& y_label, const VectorXd& t, double height) {
  Panel panel{"", y_label, false, false, true, false, t[0], t[t.size() - 1], 0, 0, {}};
  panel.height = height;
  panel.x_numbers = false;
  if (height < 1.5) panel.y_tics = 2.5;
  return panel;
}

/// Sets the y axis from low to high and a little more. Without a range gnuplot chooses it.
void set_scale(Panel& panel, double low, double high, double share_beyond = 0.05) {
  if (!(high > low)) return;
  panel.y_low = low - share_beyond * (high - low);
  panel.y_high = high + share_beyond * (high - low);
}

/// Adds a line with the points that the panel can show. Its scales must be set before.
void add_line(Panel& panel, const std::string& title, Style style, int colour, const VectorXd& t, const VectorXd& y) {
  const double height = panel.y_high - panel.y_low;
  const PixelScale scale{kLines / (panel.x_high - panel.x_low),
                         height > 0.0 ? (kPanelHeight * panel.height - kAround) / height : 1.0};
  Line line = thinned_line(t, y, scale);
  panel.series.push_back({title, style, colour, std::move(line.x), std::move(line.y), {}});
}

double lowest(const VectorXd& values) {
  return values.minCoeff<Eigen::PropagateNumbers>();
}
double highest(const VectorXd& values) {
  return values.maxCoeff<Eigen::PropagateNumbers>();
}

/// Shows truth, estimate and measurement, on a scale that an estimate far away does not determine.
Panel state_panel(const Channel& channel, const VectorXd& t, const VectorXd& truth, const VectorXd& estimate,
                  std::vector<Series> measured) {
  Panel panel = time_panel(with_unit(channel.name, channel.unit), t, 1.8);
  panel.series = std::move(measured);
  double low = lowest(truth), high = highest(truth);
  for (const Series& series : panel.series) {
    low = std::min(low, lowest(series.y));
    high = std::max(high, highest(series.y));
  }
  const double range = high - low, least = lowest(estimate), most = highest(estimate);
  std::string name = "estimate";
  if (range > 0.0 && (least < low - 0.5 * range || most > high + 0.5 * range)) {
    set_scale(panel, low, high, 0.25);
    name += fmt::format(" (beyond the scale: {} to {})", significant(least), significant(most));
  } else {
    set_scale(panel, std::min(low, least), std::max(high, most));
  }
  add_line(panel, "truth", Style::kBroadLine, kTruth, t, truth);
  add_line(panel, name, Style::kLine, kEstimate, t, estimate);
  return panel;
}

Panel error_panel(const Channel& channel, const VectorXd& t, const VectorXd& error) {
  Panel panel = time_panel(with_unit("error", channel.unit), t, 1.2);
  std::vector<double> sizes;
  for (const double value : error)
    if (std::isfinite(value)) sizes.push_back(std::abs(value));
  std::sort(sizes.begin(), sizes.end());
  std::string name = "estimate - truth";
  if (!sizes.empty() && sizes.back() > 0.0) {
    // The transient may be a hundred times larger than the rest, which would then be a line at zero.
    constexpr double kFarOut = 5.0;
    const double usual = sizes[(sizes.size() - 1) * 9 / 10];
    const bool far_out = usual > 0.0 && sizes.back() > kFarOut * usual;
    panel.y_high = far_out ? 3.0 * usual : 1.1 * sizes.back();
    panel.y_low = -panel.y_high;
    name += fmt::format(", largest {}{}", significant(sizes.back()), far_out ? " (beyond the scale)" : "");
  }
  add_line(panel, name, Style::kThinLine, kError, t, error);
  return panel;
}

/// Returns the output as the sensor shows it.
VectorXd measured_output(const EvaluatedRun& run, const Window& window, std::size_t j, const Channel& channel) {
  return wrapped(window.of(run.measured.row(static_cast<Index>(j)).transpose()), channel.wrap);
}

/// Returns true if output j is a state itself.
bool shows(const EvaluatedRun& run, std::size_t j, Index state) {
  return run.truth.outputs.row(static_cast<Index>(j)) == run.truth.states.row(state);
}

/// Returns two panels for each state.
Figure states_figure(const EvaluatedRun& run, const std::vector<Channel>& states, const std::vector<Channel>& outputs,
                     const Window& window, const VectorXd& t) {
  Figure figure{"", kWidth, kPanelHeight, false, {}};
  for (std::size_t i = 0; i < states.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const double wrap = states[i].wrap;
    std::vector<Series> sensors;
    for (std::size_t j = 0; j < outputs.size(); ++j)
      if (shows(run, j, row))
        sensors.push_back({"measured",
                           Style::kDots,
                           kMeasured,
                           thinned(t),
                           thinned(measured_output(run, window, j, outputs[j])),
                           {}});
    figure.panels.push_back(state_panel(states[i], t, window.of(wrapped(run.truth.states.row(row), wrap)),
                                        window.of(wrapped(run.estimate.row(row), wrap)), std::move(sensors)));
    figure.panels.push_back(error_panel(states[i], t, window.of(error_of(run, row, wrap))));
  }
  return figure;
}

/// Adds shading, explained in the first panel, and the time below the last one.
void finish(Figure& figure, std::vector<Band> bands, const std::string& x_label) {
  for (Panel& panel : figure.panels) {
    panel.bands = bands;
    for (Band& band : bands) band.title.clear();
  }
  Panel& last = figure.panels.back();
  last.x_label = x_label;
  last.x_numbers = true;
  last.height += 0.42;
}

std::string caption_of(const EvaluatedRun& run, const ShownRuns& shown) {
  std::string text = run.truth.source;
  if (!shown.condition.empty()) text += ", " + shown.condition;
  if (!run.why.empty() && shown.of > 1) text += fmt::format(" ({} of {})", run.why, shown.of);
  text += ": RMSE " + run_errors(run, shown.states) + ".";
  const auto share = [&](const VectorXd& flags, double flagged, const char* meaning) {
    const double part = (flags.array() == flagged).cast<double>().mean();
    return part > 0.0 ? fmt::format(" {}, {} of the samples.", meaning, percent(part)) : "";
  };
  text += share(run.truth.weight, 0.0, "Grey: not scored, the truth is masked there");
  if (run.outside.size() > 0) text += share(run.outside, 1.0, "Purple: z is outside of the training domain");
  return text;
}

}  // namespace

Figure run_figure(const EvaluatedRun& run, const std::vector<Channel>& states, const std::vector<Channel>& outputs,
                  double t0, double t1, const std::vector<Channel>& inputs) {
  const Window window(run.truth.time_s, t0, t1);
  if (window.count < 2) return {"", kWidth, kPanelHeight, false, {}};
  const VectorXd t = window.of(run.truth.time_s);
  Figure figure = states_figure(run, states, outputs, window, t);
  const auto add_signal = [&](const std::string& name, int colour, const VectorXd& y) {
    Panel panel = time_panel("", t, 1.2);  // too low for a vertical name
    set_scale(panel, lowest(y), highest(y));
    add_line(panel, name, Style::kThinLine, colour, t, y);
    figure.panels.push_back(std::move(panel));
  };
  for (std::size_t j = 0; j < outputs.size(); ++j) {
    bool drawn = false;
    for (Index i = 0; i < run.truth.states.rows(); ++i) drawn = drawn || shows(run, j, i);
    if (drawn) continue;
    add_signal(with_unit(outputs[j].name + ", measured", outputs[j].unit), kMeasured,
               measured_output(run, window, j, outputs[j]));
  }
  for (Index i = 0; i < run.truth.inputs.rows() && run.truth.inputs.rows() == std::ssize(inputs); ++i) {
    const Channel& input = inputs[static_cast<std::size_t>(i)];
    add_signal(with_unit(input.name + ", input", input.unit), kInput, window.of(run.truth.inputs.row(i)));
  }
  finish(figure, bands_of(run, window, t), "time [s]");
  return figure;
}

Figure run_picture(const EvaluatedRun& run, const std::vector<Channel>& states, const std::vector<Channel>& outputs) {
  const VectorXd& t = run.truth.time_s;
  if (t.size() < 2) return {"", kWidth, kPanelHeight, false, {}};
  const Window window(t, t[0], t[t.size() - 1]);
  Figure figure = states_figure(run, states, outputs, window, t);
  finish(figure, bands_of(run, window, t),
         fmt::format("time [s], {}: RMSE {}{}", run.truth.source, run_errors(run, states),
                     run.outside.size() > 0 && run.outside.maxCoeff() <= 0.0 ? "; all in the training domain" : ""));
  return figure;
}

std::string run_errors(const EvaluatedRun& run, const std::vector<Channel>& states) {
  std::string text;
  const double weight = run.truth.weight.sum();
  for (std::size_t i = 0; i < states.size(); ++i) {
    const VectorXd squares = error_of(run, static_cast<Index>(i), states[i].wrap).cwiseAbs2();
    const std::string value = weight > 0.0 ? significant(std::sqrt(run.truth.weight.dot(squares) / weight)) : "-";
    text += fmt::format("{}{} {}{}{}", i > 0 ? ", " : "", states[i].name, value, states[i].unit.empty() ? "" : " ",
                        states[i].unit);
  }
  return text;
}

void add_runs(Page& page, const ShownRuns& shown) {
  constexpr double kStart = 0.1;           // share of the run
  constexpr Index kEnoughToMagnify = 200;  // samples of the run
  if (shown.runs.size() < shown.of)
    page.text(fmt::format("<p class=\"soft\">{} of the {} runs: {}.</p>\n", shown.runs.size(), shown.of,
                          shown.runs.size() > 2
                              ? "the first, the best, the worst and others evenly spread over the rest"
                              : "the first and the worst"));
  page.text(
      fmt::format("<p class=\"soft\">Under each state its error, on a scale of its own. The observer starts without "
                  "knowing the state.{}</p>\n",
                  shown.of > 1 ? " Best and worst by errors in shares of each state's own spread." : ""));
  bool first = true;
  for (const EvaluatedRun& run : shown.runs) {
    const VectorXd& t = run.truth.time_s;
    if (t.size() < 2) continue;
    const double from = t[0], to = t[t.size() - 1];
    Figure whole = run_figure(run, shown.states, shown.outputs, from, to, shown.inputs);
    whole.caption = caption_of(run, shown);
    page.figure(std::move(whole));
    if (first && t.size() >= kEnoughToMagnify) {
      Figure start = run_figure(run, shown.states, shown.outputs, from, from + kStart * (to - from), shown.inputs);
      start.caption = fmt::format("The same, its start: the first {} s.", significant(kStart * (to - from), 2));
      page.figure(std::move(start));
    }
    first = false;
  }
}

}  // namespace nlo::trainer
