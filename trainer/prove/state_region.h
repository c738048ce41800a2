// SPDX-License-Identifier: MIT
// A set of states that consists of equal boxes. The proofs of an observer's error assume that the plant stays in this
// set.
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

  /// Returns a region of larger cells that contains this one. The width is multiplied by 2, 4, ..., by the smallest
  /// factor that needs at most `most_cells` cells.
  StateRegion coarser(std::size_t most_cells) const;

  const StateBox& box() const { return box_; }
  int per_state() const { return per_state_; }
  std::vector<StateBox> cells() const;
  /// Returns for each of cells() its integer position in each state (n_x), counted from the box's lowest corner.
  std::vector<Eigen::VectorXi> places() const;
  /// Returns the index of the cell that contains x, or -1 if x is not in the region.
  Eigen::Index cell_of(const Eigen::VectorXd& x) const;
  bool contains(const Eigen::VectorXd& x) const { return cell_of(x) >= 0; }
  /// Returns the share of the box that the region fills.
  double share() const;

  /// Returns `per_cell` points of each cell, n_x x N: its centre, then random ones.
  Eigen::MatrixXd points(int per_cell, unsigned seed) const;

 private:
  Eigen::Index index_of(const Eigen::VectorXd& x) const;  ///< -1 if x is outside of the box
  Eigen::VectorXi place_of(Eigen::Index index) const;
  void keep(const std::vector<bool>& within);

  StateBox box_;
  int per_state_;
  /// For each cell of the box: its index in cells(), or -1. The first state's position changes fastest.
  std::vector<Eigen::Index> rank_;
};

}  // namespace nlo::trainer
