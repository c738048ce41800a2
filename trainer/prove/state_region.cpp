// SPDX-License-Identifier: MIT
#include "trainer/prove/state_region.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

namespace nlo::trainer {
namespace {

std::size_t count_of(Eigen::Index nx, int per_state) {
  std::size_t count = 1;
  for (Eigen::Index p = 0; p < nx; ++p) count *= static_cast<std::size_t>(per_state);
  return count;
}

}  // namespace

StateRegion::StateRegion(StateBox box, int cells_per_state) : box_(std::move(box)), per_state_(cells_per_state) {
  keep(std::vector<bool>(count_of(box_.centre.size(), cells_per_state), true));
}

StateRegion StateRegion::around(const Eigen::MatrixXd& x, std::size_t most_cells) {
  constexpr int kFewest = 8, kMost = 512;
  constexpr double kLeast = 1e-6, kWider = 1.0 + 1e-6;
  const Eigen::VectorXd low = x.rowwise().minCoeff(), high = x.rowwise().maxCoeff();
  const StateBox box{0.5 * (low + high), kWider * (0.5 * (high - low)).cwiseMax(kLeast)};
  const double most_boxes = 1e7;
  StateRegion best(box, kFewest);
  for (int per_state = kFewest; per_state <= kMost; per_state *= 2) {
    if (std::pow(per_state, x.rows()) > most_boxes) break;
    StateRegion tried(box, per_state);
    std::vector<bool> within(tried.rank_.size(), false);
    for (const auto& column : x.colwise()) within[static_cast<std::size_t>(tried.index_of(column))] = true;
    tried.keep(within);
    if (per_state > kFewest && tried.places().size() > most_cells) break;
    best = std::move(tried);
  }
  return best;
}

StateRegion StateRegion::coarser(std::size_t most_cells) const {
  StateRegion result = *this;
  const std::vector<Eigen::VectorXi> own = places();
  for (int by = 2; result.places().size() > most_cells && per_state_ % by == 0; by *= 2) {
    result.per_state_ = per_state_ / by;
    std::vector<bool> within(count_of(box_.centre.size(), result.per_state_), false);
    for (const Eigen::VectorXi& place : own) {
      Eigen::Index index = 0, stride = 1;
      for (const int at : place) {
        index += at / by * stride;
        stride *= result.per_state_;
      }
      within[static_cast<std::size_t>(index)] = true;
    }
    result.keep(within);
  }
  return result;
}

void StateRegion::keep(const std::vector<bool>& within) {
  rank_.assign(within.size(), -1);
  Eigen::Index next = 0;
  for (std::size_t i = 0; i < within.size(); ++i)
    if (within[i]) rank_[i] = next++;
}

Eigen::Index StateRegion::index_of(const Eigen::VectorXd& x) const {
  Eigen::Index index = 0, stride = 1;
  for (Eigen::Index p = 0; p < x.size(); ++p, stride *= per_state_) {
    const double at = 0.5 * (1.0 + (x(p) - box_.centre(p)) / box_.radius(p)) * per_state_;
    if (!(at >= 0.0 && at < per_state_)) return -1;
    index += static_cast<Eigen::Index>(at) * stride;
  }
  return index;
}

Eigen::VectorXi StateRegion::place_of(Eigen::Index index) const {
  Eigen::VectorXi place(box_.centre.size());
  for (int& at : place) {
    at = static_cast<int>(index % per_state_);
    index /= per_state_;
  }
  return place;
}

Eigen::Index StateRegion::cell_of(const Eigen::VectorXd& x) const {
  const Eigen::Index index = index_of(x);
  return index < 0 ? -1 : rank_[static_cast<std::size_t>(index)];
}

std::vector<Eigen::VectorXi> StateRegion::places() const {
  std::vector<Eigen::VectorXi> places;
  for (std::size_t i = 0; i < rank_.size(); ++i)
    if (rank_[i] >= 0) places.push_back(place_of(static_cast<Eigen::Index>(i)));
  return places;
}

double StateRegion::share() const {
  return static_cast<double>(places().size()) / static_cast<double>(rank_.size());
}

std::vector<StateBox> StateRegion::cells() const {
  constexpr double kOverlap = 1.0 + 1e-9;  // prevents gaps between cells from rounding
  const Eigen::VectorXd radius = box_.radius / per_state_;
  std::vector<StateBox> cells;
  for (const Eigen::VectorXi& place : places())
    cells.push_back({box_.centre - box_.radius +
                         radius.cwiseProduct(2.0 * place.cast<double>() + Eigen::VectorXd::Ones(place.size())),
                     radius * kOverlap});
  return cells;
}

Eigen::MatrixXd StateRegion::points(int per_cell, unsigned seed) const {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const std::vector<StateBox> all = cells();
  const auto count = static_cast<Eigen::Index>(all.size());
  Eigen::MatrixXd points(box_.centre.size(), count * per_cell);
  for (Eigen::Index c = 0; c < count; ++c) {
    const StateBox& cell = all[static_cast<std::size_t>(c)];
    for (int i = 0; i < per_cell; ++i)
      points.col(c * per_cell + i) =
          i == 0 ? cell.centre
                 : Eigen::VectorXd(cell.centre + cell.radius.unaryExpr([&](double r) { return r * uniform(engine); }));
  }
  return points;
}

}  // namespace nlo::trainer
