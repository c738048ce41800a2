// SPDX-License-Identifier: MIT
#include "trainer/app/report/pareto_figure.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace nlo::trainer {
namespace {

struct Place {
  double cost, error, deviation;
  std::string title = {};
};

/// Shortens a title so that it fits beside a point.
std::string shortened(const std::string& title) {
  constexpr std::size_t kLongest = 60;
  if (title.size() <= kLongest) return title;
  std::size_t end = kLongest;
  while (end > 0 && (static_cast<unsigned char>(title[end]) & 0xC0) == 0x80) --end;  // not inside of a UTF-8 character
  return title.substr(0, end) + "...";
}

Series series_of(const std::string& title, Series::Style style, int colour, const std::vector<Place>& places) {
  const auto count = static_cast<Eigen::Index>(places.size());
  Series series{title, style, colour, Eigen::VectorXd(count), Eigen::VectorXd(count), {}, Eigen::VectorXd(count)};
  for (Eigen::Index i = 0; i < count; ++i) {
    const Place& place = places[static_cast<std::size_t>(i)];
    series.x[i] = place.cost;
    series.y[i] = place.error;
    series.error[i] = place.deviation;
    series.labels.push_back(shortened(place.title));
  }
  return series;
}

/// Returns the smallest error for each cost. It falls at each point of the front and is constant between them.
std::vector<Place> staircase(std::vector<Place> front) {
  std::sort(front.begin(), front.end(), [](const Place& a, const Place& b) { return a.cost < b.cost; });
  std::vector<Place> steps;
  for (const Place& place : front) {
    if (!steps.empty()) steps.push_back({place.cost, steps.back().error, 0.0});
    steps.push_back(place);
  }
  return steps;
}

/// Sets a logarithmic axis around the values.
void set_range(double low, double high, double& axis_low, double& axis_high) {
  constexpr double kMargin = 1.15;
  axis_low = low / kMargin;
  axis_high = high * kMargin;
}

Panel panel_of(const std::vector<PointResult>& points, CostOf cost, bool PointResult::*best) {
  std::vector<Place> others, front;
  for (const PointResult& point : points) {
    if (!point.error || !point.cost || !cost(*point.cost)) continue;
    const Place place{*cost(*point.cost), *point.error, point.standard_error.value_or(0.0), point.title};
    (point.*best ? front : others).push_back(place);
  }
  Panel panel;
  if (front.empty()) return panel;
  panel.log_x = true;
  panel.y_label = "error norm";
  std::vector<Place> all = others;
  all.insert(all.end(), front.begin(), front.end());
  const auto [least, most] =
      std::minmax_element(all.begin(), all.end(), [](const Place& a, const Place& b) { return a.cost < b.cost; });
  set_range(least->cost, most->cost, panel.x_low, panel.x_high);
  const auto by_error = [](const Place& a, const Place& b) { return a.error < b.error; };
  const double low = std::ranges::min_element(all, by_error)->error,
               high = std::ranges::max_element(all, by_error)->error;
  if (high > low) {  // room for the names below the front, where there are no points
    panel.y_low = low - 0.2 * (high - low);
    panel.y_high = high + 0.1 * (high - low);
  }
  const double middle = std::sqrt(least->cost * most->cost);
  std::vector<Place> left, right;
  for (const Place& place : front) (place.cost < middle ? left : right).push_back(place);
  panel.series.push_back(series_of("", Series::Style::kThinLine, 1, staircase(front)));
  panel.series.push_back(series_of("dominated", Series::Style::kErrorBars, 5, others));
  panel.series.push_back(series_of("Pareto front", Series::Style::kErrorBars, 1, front));
  panel.series.push_back(series_of("", Series::Style::kTextRight, 1, left));
  panel.series.push_back(series_of("", Series::Style::kTextLeft, 1, right));
  return panel;
}

}  // namespace

Figure pareto_figure(const std::vector<PointResult>& points) {
  Figure figure;
  figure.panel_height = 290;
  Panel multiply_adds = panel_of(points, multiply_adds_of, &PointResult::best_for_multiply_adds);
  if (multiply_adds.series.empty()) return figure;
  multiply_adds.x_label = "multiply-adds of a step and an estimate";
  Panel flash = panel_of(points, flash_bytes_of, &PointResult::best_for_flash);
  flash.x_label = "constants in flash [bytes], float";
  figure.panels = {std::move(multiply_adds), std::move(flash)};
  Panel ns = panel_of(points, ns_of, &PointResult::best_for_ns);
  if (ns.series.empty()) return figure;
  ns.x_label = "ns of a step and an estimate, here";
  figure.panels.push_back(std::move(ns));
  return figure;
}

}  // namespace nlo::trainer
