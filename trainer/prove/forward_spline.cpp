// SPDX-License-Identifier: MIT
#include "trainer/prove/forward_spline.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/prove/hermite_cells.h"
#include "trainer/prove/rounding.h"

namespace nlo::trainer {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

ForwardSpline::ForwardSpline(const PlantEnclosure& plant, LatentSystem system, const StateRegion& region,
                             HoldEffect hold, const Matrix& x, const Matrix& z)
    : plant_(plant),
      region_(region),
      system_(std::move(system)),
      d_(apply_d(system_, Matrix::Identity(system_.nz(), system_.nz()))),
      hold_(hold),
      shared_(plant.nx() < 3 ? 3 : 2),
      cells_(region.cells()) {
  const Eigen::Index nx = plant_.nx(), nz = system_.nz(), n = 2 * shared_;
  if (nx > static_cast<Eigen::Index>(kMostStates))
    throw codegen::Error("a proof over a region of states needs a plant with at most 3 states");
  powers_ = all_powers<Powers>(static_cast<std::size_t>(nx), static_cast<int>(n) - 1);
  // Each corner has m^n_x unknowns. For each state, a cell lists the unknowns of its left end first, then those of its
  // right end.
  std::vector<Eigen::Index> first_of_corner;
  const Eigen::Index corners = region.per_state() + 1;
  Eigen::Index per_corner = 1, count = 1;
  for (Eigen::Index p = 0; p < nx; ++p) {
    per_corner *= shared_;
    count *= corners;
  }
  first_of_corner.assign(static_cast<std::size_t>(count), -1);
  for (const Eigen::VectorXi& place : region.places()) {
    std::vector<Eigen::Index> own;
    for (const Powers& power : powers_) {
      Eigen::Index corner = 0, stride = 1, within = 0, step = 1;
      for (Eigen::Index p = 0; p < nx; ++p) {
        const int at = power[static_cast<std::size_t>(p)];
        corner += (place(p) + at / shared_) * stride;
        within += at % shared_ * step;
        stride *= corners;
        step *= shared_;
      }
      Eigen::Index& first = first_of_corner[static_cast<std::size_t>(corner)];
      if (first < 0) {
        first = unknown_count_;
        unknown_count_ += per_corner;
      }
      own.push_back(first + within);
    }
    unknowns_.push_back(std::move(own));
  }
  const Matrix to_polynomial = hermite(shared_);
  const auto products = static_cast<Eigen::Index>(powers_.size());
  coefficients_.assign(cells_.size(), Matrix::Zero(products, nz));
  double largest = 0.0;
  for (const LatentMode& mode : modes_of(system_)) {
    if (!mode.driven) continue;  // a clock runs down to 0
    const Eigen::MatrixXcd all = fitted(mode, x, z);
    largest = std::max(largest, all.cwiseAbs().maxCoeff());
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      Eigen::MatrixXcd own(products, 1);
      for (Eigen::Index k = 0; k < products; ++k) own(k, 0) = all(unknowns_[c][static_cast<std::size_t>(k)], 0);
      along_states(own, nx, n, [&](Eigen::Index) { return to_polynomial; });
      coefficients_[c].col(mode.row) = own.real();
      if (mode.rows == 2) coefficients_[c].col(mode.row + 1) = own.imag();
    }
  }
  // The error comes from rounding: in the inverse that made `to_polynomial`, and in the sums of its products.
  const double size = std::pow(to_polynomial.cwiseAbs().rowwise().sum().maxCoeff(), nx);
  error_ = gamma(100 * n * nx) * size * largest * 2.0;
}

ForwardSpline::Local ForwardSpline::local(const StateBox& box, const Vector& unit) const {
  const Eigen::Index nx = plant_.nx(), nz = system_.nz(), n = 2 * shared_;
  const Eigen::Index cell = region_.cell_of(box.centre);
  if (cell < 0) throw codegen::Error("the box is outside of the region, where the spline is not defined");
  const StateBox& own = cells_[static_cast<std::size_t>(cell)];
  Local local{coefficients_[static_cast<std::size_t>(cell)], Matrix(static_cast<Eigen::Index>(powers_.size()), nz)};
  const Vector largest = local.coefficients.cwiseAbs().colwise().maxCoeff();
  Matrix growth(n, nx);  // growth of the coefficients' errors, for each power of each state
  along_states(local.coefficients, nx, n, [&](Eigen::Index p) {
    const double from = (box.centre(p) - own.centre(p)) / own.radius(p), by = unit(p) / own.radius(p);
    Matrix shift = Matrix::Zero(n, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      double binomial = 1.0;
      for (Eigen::Index i = 0; i <= k; ++i) {
        shift(i, k) = binomial * std::pow(from, k - i) * std::pow(by, i);
        binomial *= static_cast<double>(k - i) / static_cast<double>(i + 1);
      }
    }
    growth.col(p) = shift.cwiseAbs().rowwise().sum();
    return shift;
  });
  for (std::size_t k = 0; k < powers_.size(); ++k) {
    double grown = 1.01;
    for (Eigen::Index p = 0; p < nx; ++p) grown *= growth(powers_[k][static_cast<std::size_t>(p)], p);
    for (Eigen::Index r = 0; r < nz; ++r)  // coefficients that are all 0 are exact
      local.errors(static_cast<Eigen::Index>(k), r) =
          largest(r) == 0.0 ? 0.0 : grown * (error_ + gamma(100 * n * nx) * largest(r));
  }
  return local;
}

MapRanges ForwardSpline::over(const StateBox& box) const {
  const Eigen::Index nx = plant_.nx(), nz = system_.nz();
  const Eigen::Index cell = region_.cell_of(box.centre);
  // A direction without width needs a unit of distance too; any unit is correct.
  Vector unit = box.radius;
  for (Eigen::Index p = 0; p < nx; ++p)
    if (unit(p) == 0.0) unit(p) = cells_[static_cast<std::size_t>(std::max<Eigen::Index>(cell, 0))].radius(p);
  const Local polynomial = local(box, unit);
  MapRanges ranges{IntervalMatrix(nz), IntervalMatrix(nz, nx), Vector::Zero(nz), IntervalMatrix(nz, nx)};
  // Size of a product and of its slopes. It is 0 if a factor is the distance in a direction without width.
  const auto size_of = [&](double size, const Powers& power) {
    for (Eigen::Index p = 0; p < nx; ++p)
      if (power[static_cast<std::size_t>(p)] > 0 && box.radius(p) == 0.0) return 0.0;
    return size;
  };
  constexpr double kUp = 1.0 + 1e-12;  // sums of at most 1e4 terms that are not negative
  Vector first(nx), off(nx), beside(nx);
  for (Eigen::Index r = 0; r < nz; ++r) {
    double bent = 0.0;
    beside.setZero();
    for (std::size_t k = 0; k < powers_.size(); ++k) {
      Powers power = powers_[k];
      const int total = std::accumulate(power.begin(), power.end(), 0);
      const auto row = static_cast<Eigen::Index>(k);
      const double value = polynomial.coefficients(row, r), error = polynomial.errors(row, r);
      const double size = std::abs(value) + error;
      if (total >= 2) bent += size_of(size, power);
      for (Eigen::Index p = 0; p < nx; ++p) {
        int& of_p = power[static_cast<std::size_t>(p)];
        if (of_p == 0) continue;
        const double factor = of_p--;
        if (total == 1) {
          first(p) = value;
          off(p) = error;
        } else {
          beside(p) += size_of(factor * size, power);
        }
        ++of_p;
      }
    }
    ranges.at_centre(r) = around(polynomial.coefficients(0, r), polynomial.errors(0, r));
    ranges.bent(r) = bent * kUp;
    for (Eigen::Index p = 0; p < nx; ++p) {
      ranges.slopes_at_centre(r, p) = around(first(p), off(p)) / Interval(unit(p));
      ranges.slopes(r, p) = around(first(p), (off(p) + beside(p)) * kUp) / Interval(unit(p));
    }
  }
  return ranges;
}

Vector ForwardSpline::residual(const StateBox& box) const {
  const Eigen::Index nx = plant_.nx(), nz = system_.nz(), ny = plant_.ny();
  const std::vector<TaylorModel> plant = plant_.models_over(box);
  const auto rate = [&](Eigen::Index i, Eigen::Index j) { return plant[static_cast<std::size_t>(nx + i * ny + j)]; };
  const Local polynomial = local(box, box.radius);
  std::vector<TaylorModel> map(static_cast<std::size_t>(nz));
  std::vector<std::vector<TaylorModel>> slopes(map.size(), std::vector<TaylorModel>(static_cast<std::size_t>(nx)));
  for (std::size_t r = 0; r < map.size(); ++r) {
    for (std::size_t k = 0; k < powers_.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k), column = static_cast<Eigen::Index>(r);
      const double value = polynomial.coefficients(row, column), error = polynomial.errors(row, column);
      map[r].add(powers_[k], value);
      map[r].widen(error);
      for (std::size_t p = 0; p < slopes[r].size(); ++p) {
        Powers power = powers_[k];
        if (power[p] == 0) continue;
        const double factor = power[p]-- / box.radius(static_cast<Eigen::Index>(p));
        slopes[r][p].add(power, factor * value);
        slopes[r][p].widen(factor * (error + 4.0 * kUnit * std::abs(value)));
      }
    }
  }
  const Matrix crossed = hold_.crossed * (d_ * system_.injection);
  Vector result(nz);
  for (Eigen::Index r = 0; r < nz; ++r) {
    TaylorModel left;
    for (Eigen::Index p = 0; p < nx; ++p)
      left =
          left + slopes[static_cast<std::size_t>(r)][static_cast<std::size_t>(p)] * plant[static_cast<std::size_t>(p)];
    for (Eigen::Index s = 0; s < nz; ++s)
      if (d_(r, s) != 0.0) left = left - TaylorModel(d_(r, s)) * map[static_cast<std::size_t>(s)];
    for (Eigen::Index j = 0; j < ny; ++j) {
      left = left - TaylorModel(system_.injection(r, j)) *
                        (rate(0, j) + TaylorModel(hold_.first) * rate(1, j) + TaylorModel(hold_.second) * rate(2, j));
      if (crossed(r, j) == 0.0) continue;
      left = left - TaylorModel(crossed(r, j)) * rate(1, j);
      left.widen(1e-12 * std::abs(crossed(r, j)) * rate(1, j).most());
    }
    result(r) = left.most();
  }
  return result;
}

}  // namespace nlo::trainer
