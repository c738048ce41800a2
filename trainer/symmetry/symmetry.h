// SPDX-License-Identifier: MIT
// A declared symmetry on the rows of data: what its elements make of readings and states.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/symmetry/kinds.h"

namespace nlo::trainer {

/// Which rows of a signal a symmetry moves.
struct MovedRows {
  struct Angle {
    int row;            ///< of its sine where `sincos`; its cosine follows
    bool sincos;        ///< else a plain channel
    double wrap = 0.0;  ///< full turn
  };
  std::vector<std::vector<int>> vectors;
  std::vector<Angle> angles;
};

struct Symmetry {
  const SymmetryKind* kind = nullptr;
  int components = 0;  ///< of its vectors
  int fold = 0;
  MovedRows readings, states;  ///< readings: outputs, then inputs
};

/// Channels by their names; an angle as NAME_sin and NAME_cos by NAME. What is not among them (a state that is not
/// estimated) stays out.
Symmetry on_channels(const SymmetryConfig& config, const std::vector<codegen::Channel>& readings,
                     const std::vector<codegen::Channel>& states);

std::vector<Symmetry> on_channels(const std::vector<SymmetryConfig>& configs,
                                  const std::vector<codegen::Channel>& readings,
                                  const std::vector<codegen::Channel>& states);

/// What elements make of the rows of a signal: each becomes a sum of rows times factors, and an offset.
class RowMap {
 public:
  struct Term {
    int row;
    double factor;
  };
  struct Row {
    std::vector<Term> terms;
    double offset = 0.0;
  };

  RowMap() = default;  ///< leaves every row as it is
  explicit RowMap(int rows);

  bool none() const { return rows_.empty(); }
  const Row& row(int row) const { return rows_[static_cast<std::size_t>(row)]; }

  /// Appends an element: what the map gave is moved by it.
  void then(const MovedRows& moved, const Element& element);

  /// Of row `row`, where `signal(row)` was. Without the offset: of a derivative.
  template <class T, class Signal>
  T derivative(int row, const Signal& signal) const {
    if (none()) return signal(row);
    const Row& own = rows_[static_cast<std::size_t>(row)];
    T sum = static_cast<T>(own.terms[0].factor) * signal(own.terms[0].row);
    for (std::size_t i = 1; i < own.terms.size(); ++i)
      sum += static_cast<T>(own.terms[i].factor) * signal(own.terms[i].row);
    return sum;
  }
  template <class T, class Signal>
  T value(int row, const Signal& signal) const {
    const T sum = derivative<T>(row, signal);
    return none() || rows_[static_cast<std::size_t>(row)].offset == 0.0
               ? sum
               : sum + static_cast<T>(rows_[static_cast<std::size_t>(row)].offset);
  }
  Eigen::MatrixXd values(const Eigen::MatrixXd& signal) const;
  Eigen::MatrixXd derivatives(const Eigen::MatrixXd& signal) const;

 private:
  std::vector<Row> rows_;
};

/// One element of all declared symmetries together; by itself the identity.
struct Image {
  RowMap readings, states;
};

Image image_of(const Symmetry& symmetry, const Element& element, int readings, int states);

/// One element of each, one after the other.
Image draw_image(const std::vector<Symmetry>& symmetries, int readings, int states, const Uniform& uniform);

/// The few that stand for all but the identity (SymmetryKind::others), symmetry after symmetry.
std::vector<Image> other_images(const std::vector<Symmetry>& symmetries, int readings, int states);

/// The mean of readings over all images of them.
Eigen::VectorXd mean_of_images(const std::vector<Symmetry>& symmetries, const Eigen::VectorXd& readings);

/// Widens the ranges of readings to those of their images by other_images(). An empty one (low > high) is no number of
/// anything and stays.
void widen_by_images(const std::vector<Symmetry>& symmetries, Eigen::VectorXd& low, Eigen::VectorXd& high);

}  // namespace nlo::trainer
