// SPDX-License-Identifier: MIT
// The least-squares fit of a spline T~.
#include <Eigen/SparseCholesky>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "codegen/base/error.h"
#include "trainer/prove/forward_spline.h"
#include "trainer/prove/hermite_cells.h"

namespace nlo::trainer {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

Eigen::MatrixXcd ForwardSpline::fitted(const LatentMode& mode, const Matrix& x, const Matrix& z) const {
  // A ridge, relative to the largest diagonal entry. It keeps the equations solvable where (5) does not determine T~,
  // as near an attracting orbit.
  constexpr double kRidge = 1e-14;
  using Sparse = Eigen::SparseMatrix<std::complex<double>>;
  const Eigen::Index nx = plant_.nx(), n = 2 * shared_;
  const auto products = static_cast<Eigen::Index>(powers_.size());
  const Matrix to_polynomial = hermite(shared_);
  // The Hermite shape functions of a cell in one state, at a distance from the cell's centre, and their slopes.
  const auto shapes = [&](double distance) {
    Eigen::RowVectorXd powers(n);
    for (Eigen::Index k = 0; k < n; ++k) powers(k) = std::pow(distance, k);
    return Eigen::RowVectorXd(powers * to_polynomial);
  };
  const auto shape_slopes = [&](double distance) {
    Eigen::RowVectorXd powers = Eigen::RowVectorXd::Zero(n);
    for (Eigen::Index k = 1; k < n; ++k) powers(k) = static_cast<double>(k) * std::pow(distance, k - 1);
    return Eigen::RowVectorXd(powers * to_polynomial);
  };
  // Each cell has more points than unknowns, so that the polynomial cannot oscillate between the points.
  const Eigen::Index side = n + 1;
  Matrix values(side, n), slopes(side, n);
  Vector at(side);
  for (Eigen::Index i = 0; i < side; ++i) {
    at(i) = std::cos(std::numbers::pi * static_cast<double>(i) / static_cast<double>(side - 1));
    values.row(i) = shapes(at(i));
    slopes.row(i) = shape_slopes(at(i));
  }
  const auto places = all_powers<Powers>(static_cast<std::size_t>(nx), static_cast<int>(side) - 1);
  std::vector<std::vector<Eigen::Index>> met(cells_.size());  // for each cell: columns of x in it
  for (Eigen::Index b = 0; b < x.cols(); ++b) {
    const Eigen::Index cell = region_.cell_of(x.col(b));
    if (cell < 0) continue;
    std::vector<Eigen::Index>& own = met[static_cast<std::size_t>(cell)];
    if (own.size() < powers_.size()) own.push_back(b);
  }
  std::vector<Eigen::Triplet<std::complex<double>>> entries;
  Eigen::MatrixXcd right = Eigen::MatrixXcd::Zero(unknown_count_, 1);
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    Eigen::MatrixXcd rows(static_cast<Eigen::Index>(places.size()), products);
    Eigen::VectorXcd wanted(rows.rows());
    for (Eigen::Index point = 0; point < rows.rows(); ++point) {
      const Powers& place = places[static_cast<std::size_t>(point)];
      StateBox box{cells_[c].centre, Vector::Zero(nx)};
      for (Eigen::Index p = 0; p < nx; ++p)
        box.centre(p) += cells_[c].radius(p) * at(place[static_cast<std::size_t>(p)]);
      const PlantRanges ranges = plant_.over(box);
      const Vector f = ranges.f.middle();
      const Vector y = ranges.rates[0].middle(), rate = ranges.rates[1].middle(), second = ranges.rates[2].middle();
      wanted(point) = (mode.f * (y + hold_.first * rate + hold_.second * second))(0) +
                      hold_.crossed * mode.lambda * (mode.f * rate)(0);
      for (Eigen::Index k = 0; k < products; ++k) {
        double value = 1.0, moved = 0.0;
        for (Eigen::Index p = 0; p < nx; ++p) {
          const int i = place[static_cast<std::size_t>(p)];
          const int shape = powers_[static_cast<std::size_t>(k)][static_cast<std::size_t>(p)];
          moved = moved * values(i, shape) + value * slopes(i, shape) * f(p) / cells_[c].radius(p);
          value *= values(i, shape);
        }
        rows(point, k) = moved - mode.lambda * value;
      }
    }
    Eigen::MatrixXcd square = rows.adjoint() * rows;
    Eigen::VectorXcd to_right = rows.adjoint() * wanted;
    Eigen::RowVectorXd row(products);
    for (const Eigen::Index b : met[c]) {
      const Vector distance = (x.col(b) - cells_[c].centre).cwiseQuotient(cells_[c].radius);
      row.setOnes();
      for (Eigen::Index p = 0; p < nx; ++p) {
        const Eigen::RowVectorXd own = shapes(distance(p));
        for (Eigen::Index k = 0; k < products; ++k)
          row(k) *= own(powers_[static_cast<std::size_t>(k)][static_cast<std::size_t>(p)]);
      }
      const std::complex<double> value(z(mode.row, b), mode.rows == 2 ? z(mode.row + 1, b) : 0.0);
      square += row.transpose() * row;
      to_right += row.transpose() * value;
    }
    for (Eigen::Index i = 0; i < products; ++i) {
      right(unknowns_[c][static_cast<std::size_t>(i)], 0) += to_right(i);
      for (Eigen::Index j = 0; j < products; ++j)
        entries.emplace_back(unknowns_[c][static_cast<std::size_t>(i)], unknowns_[c][static_cast<std::size_t>(j)],
                             square(i, j));
    }
  }
  Sparse normal(unknown_count_, unknown_count_);
  normal.setFromTriplets(entries.begin(), entries.end());
  const double ridge = kRidge * normal.diagonal().cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < unknown_count_; ++i) normal.coeffRef(i, i) += ridge;
  const Eigen::SimplicialLDLT<Sparse> factors(normal);
  Eigen::MatrixXcd solved = factors.solve(right);
  if (factors.info() != Eigen::Success || !solved.allFinite())
    throw codegen::Error(
        "no spline solves (5) over this region, because the plant's equations have no value in a part of it; give a "
        "smaller --box");
  return solved;
}

}  // namespace nlo::trainer
