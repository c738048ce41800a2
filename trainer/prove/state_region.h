// SPDX-License-Identifier: MIT
// A set of states made of equal boxes, in which a plant is assumed to stay. Bounds of an observer's error are proven
// for this set.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "trainer/prove/plant_enclosure.h"

namespace nlo::trainer {

class StateRegion {
 public:
  /// The whole box.
  StateRegion(StateBox box, int cells_per_state);

  /// Returns the cells that contain columns of `x` (n_x x N), with the smallest width that needs at most `most_cells`.
  static StateRegion around(const Eigen::MatrixXd& x, std::size_t most_cells);

  /// Returns cells of twice, four, ... times the width that contain this region, with the smallest width that needs at
  /// most `most_cells`.
  StateRegion coarser(std::size_t most_cells) const;

  const StateBox& box() const { return box_; }
  int per_state() const { return per_state_; }
  std::vector<StateBox> cells() const;
  /// Returns the place of each of cells(), counted from the box's lowest corner, n_x each.
  std::vector<Eigen::VectorXi> places() const;
  /// Returns the index of the cell that contains x, or -1 if x is not in the region.
  Eigen::Index cell_of(const Eigen::VectorXd& x) const;
  bool contains(const Eigen::VectorXd& x) const { return cell_of(x) >= 0; }
  /// Returns the share of the box that the region fills.
  double share() const;

  /// Returns `per_cell` points of each cell, n_x x N: its centre, then random ones.
  Eigen::MatrixXd points(int per_cell, unsigned seed) const;

 private:
  Eigen::Index index_of(const Eigen::VectorXd& x) const;  ///< -1: outside of the box
  Eigen::VectorXi place_of(Eigen::Index index) const;
  void keep(const std::vector<bool>& within);

  StateBox box_;
  int per_state_;
  /// Index in cells() of each cell of the box, or -1; the first state goes fastest.
  std::vector<Eigen::Index> rank_;
};

}  // namespace nlo::trainer
