// SPDX-License-Identifier: MIT
// A set of states made of equal boxes: where a plant is assumed to stay. What is proven of an observer's error holds
// there.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "trainer/prove/plant_enclosure.h"

namespace nlo::trainer {

class StateRegion {
 public:
  /// All of a box.
  StateRegion(StateBox box, int cells_per_state);

  /// The cells in which columns of `x` (n_x x N) lie: the smallest ones of which there are not more than `most_cells`.
  static StateRegion around(const Eigen::MatrixXd& x, std::size_t most_cells);

  /// The cells of twice, four, ... times the width that hold this region: the first of which there are at most
  /// `most_cells`.
  StateRegion coarser(std::size_t most_cells) const;

  const StateBox& box() const { return box_; }
  int per_state() const { return per_state_; }
  std::vector<StateBox> cells() const;
  /// Place of each of cells(), counted from the box's lowest corner, n_x each.
  std::vector<Eigen::VectorXi> places() const;
  /// Which of cells() x lies in; -1: it is not in the region.
  Eigen::Index cell_of(const Eigen::VectorXd& x) const;
  bool contains(const Eigen::VectorXd& x) const { return cell_of(x) >= 0; }
  /// Share of the box that the region fills.
  double share() const;

  /// `per_cell` points of each cell, n_x x N: its centre, then drawn ones.
  Eigen::MatrixXd points(int per_cell, unsigned seed) const;

 private:
  Eigen::Index index_of(const Eigen::VectorXd& x) const;  ///< -1: outside of the box
  Eigen::VectorXi place_of(Eigen::Index index) const;
  void keep(const std::vector<bool>& within);

  StateBox box_;
  int per_state_;
  /// Place of each cell of the box among cells(), or -1; the first state goes fastest.
  std::vector<Eigen::Index> rank_;
};

}  // namespace nlo::trainer
