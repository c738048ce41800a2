// SPDX-License-Identifier: MIT
#include "trainer/app/report/thinning.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kColumn = 0.5, kTolerance = 0.4;  // pixels

/// Returns samples in [from, to) by columns: the first, then the lowest and the highest of each column, then the last.
std::vector<Index> extremes_of_columns(const VectorXd& x, const VectorXd& y, double pixels_per_unit, Index from,
                                       Index to) {
  std::vector<Index> kept{from};
  const auto column = [&](Index k) { return std::floor((x[k] - x[from]) * pixels_per_unit / kColumn); };
  for (Index k = from; k < to;) {
    Index low = k, high = k;
    const double here = column(k);
    for (; k < to && column(k) == here; ++k) {
      if (y[k] < y[low]) low = k;
      if (y[k] > y[high]) high = k;
    }
    for (const Index one : {std::min(low, high), std::max(low, high)})
      if (one > kept.back()) kept.push_back(one);
  }
  if (kept.back() < to - 1) kept.push_back(to - 1);
  return kept;
}

class Piece {
 public:
  Piece(const VectorXd& x, const VectorXd& y, PixelScale scale, std::vector<Index> points)
      : x_(x), y_(y), scale_(scale), points_(std::move(points)), needed_(points_.size(), false) {}

  /// Returns the points that are needed.
  std::vector<Index> simplified() {
    const auto above = [this](Index a, Index b) { return y_[a] < y_[b]; };
    const auto [low, high] = std::minmax_element(points_.begin(), points_.end(), above);
    std::vector<std::size_t> corners{0, static_cast<std::size_t>(low - points_.begin()),
                                     static_cast<std::size_t>(high - points_.begin()), points_.size() - 1};
    std::sort(corners.begin(), corners.end());
    for (std::size_t i = 0; i < corners.size(); ++i) {
      needed_[corners[i]] = true;
      if (i > 0) between(corners[i - 1], corners[i]);
    }
    std::vector<Index> kept;
    for (std::size_t i = 0; i < points_.size(); ++i)
      if (needed_[i]) kept.push_back(points_[i]);
    return kept;
  }

 private:
  /// Returns the squared distance in pixels of point i from the straight line through points a and b.
  double squared_distance(std::size_t i, std::size_t a, std::size_t b) const {
    const auto apart = [this](std::size_t p, std::size_t q) {
      return Eigen::Vector2d((x_[points_[p]] - x_[points_[q]]) * scale_.x,
                             (y_[points_[p]] - y_[points_[q]]) * scale_.y);
    };
    const Eigen::Vector2d along = apart(b, a), to = apart(i, a);
    const double length = along.squaredNorm();
    const double part = length > 0.0 ? std::clamp(to.dot(along) / length, 0.0, 1.0) : 0.0;
    return (to - part * along).squaredNorm();
  }

  /// Applies Douglas and Peucker's method with a list instead of recursion, which could be as deep as there are points.
  void between(std::size_t first, std::size_t last) {
    std::vector<std::pair<std::size_t, std::size_t>> open{{first, last}};
    while (!open.empty()) {
      const auto [a, b] = open.back();
      open.pop_back();
      double most = kTolerance * kTolerance;
      std::size_t farthest = a;
      for (std::size_t i = a + 1; i < b; ++i) {
        const double distance = squared_distance(i, a, b);
        if (distance <= most) continue;
        most = distance;
        farthest = i;
      }
      if (farthest == a) continue;
      needed_[farthest] = true;
      open.emplace_back(a, farthest);
      open.emplace_back(farthest, b);
    }
  }

  const VectorXd &x_, &y_;
  PixelScale scale_;
  std::vector<Index> points_;
  std::vector<bool> needed_;
};

}  // namespace

Line thinned_line(const VectorXd& x, const VectorXd& y, PixelScale scale) {
  std::vector<Index> kept;
  for (Index from = 0; from < y.size();) {
    if (!std::isfinite(y[from])) {
      kept.push_back(from++);
      while (from < y.size() && !std::isfinite(y[from])) ++from;  // several gaps in a row are one
      continue;
    }
    Index to = from;
    while (to < y.size() && std::isfinite(y[to])) ++to;
    const std::vector<Index> own = Piece(x, y, scale, extremes_of_columns(x, y, scale.x, from, to)).simplified();
    kept.insert(kept.end(), own.begin(), own.end());
    from = to;
  }
  return {x(kept), y(kept)};
}

}  // namespace nlo::trainer
