// SPDX-License-Identifier: MIT
#include "trainer/certificates/forward_spline.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/base/linear_algebra.h"
#include "trainer/bounds/rounding.h"

namespace nlo::trainer {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// From [value, derivatives] at -1, then at 1, `m` each, to the coefficients of the polynomial of degree 2 m - 1.
Matrix hermite(int m) {
  Matrix conditions(2 * m, 2 * m);
  for (int end = 0; end < 2; ++end)
    for (int i = 0; i < m; ++i)
      for (int k = 0; k < 2 * m; ++k) {
        double factor = k >= i ? 1.0 : 0.0;
        for (int j = 0; j < i; ++j) factor *= k - j;
        conditions(end * m + i, k) = factor * (end == 0 && (k - i) % 2 != 0 ? -1.0 : 1.0);
      }
  return codegen::inverse(conditions);
}

/// Every product of at most `degree` in each state.
template <class Powers>
std::vector<Powers> all_powers(std::size_t nx, int degree) {
  std::vector<Powers> powers;
  Powers at{};
  for (;;) {
    powers.push_back(at);
    std::size_t p = 0;
    while (p < nx && at[p] == degree) at[p++] = 0;
    if (p == nx) return powers;
    ++at[p];
  }
}

/// Applies `map` along each state of a tensor, the first state fastest: `of_state(p)` (n x n) along state p. The state
/// that is done goes to the slowest place, so that after all of them the order is as before.
template <class Scalar, class OfState>
void along_states(Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>& columns, Eigen::Index nx, Eigen::Index n,
                  const OfState& of_state) {
  using Block = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  const Eigen::Index rest = columns.rows() / n;
  for (Eigen::Index p = 0; p < nx; ++p) {
    const Matrix map = of_state(p);
    for (Eigen::Index c = 0; c < columns.cols(); ++c) {
      const Block done = map * Eigen::Map<Block>(columns.col(c).data(), n, rest);
      Eigen::Map<Block>(columns.col(c).data(), rest, n) = done.transpose();
    }
  }
}

}  // namespace

HoldEffect::HoldEffect(Hold hold, double dt_s) {
  // Averages over a step of what the hold reads less y: -s, and s (dt - s) / 2 with a line between samples.
  second = dt_s * dt_s / 12.0;
  if (hold != Hold::kZeroOrder) return;
  first = -0.5 * dt_s;
  crossed = second;
}

double HoldEffect::left_over(Hold hold, double dt_s, double eigenvalue_size, const std::array<double, 3>& rates,
                             const std::array<double, 3>& pushes) {
  // Taylor's remainders, integrated over a step; .0321 = integral of |s (1 - s) / 2 - 1 / 12| over [0, 1].
  const double l = eigenvalue_size, fourth = std::pow(dt_s, 4);
  const double pushed = dt_s * dt_s * (pushes[0] + dt_s * (pushes[1] + dt_s * pushes[2]));
  if (hold != Hold::kZeroOrder) return fourth * (rates[2] / 6.0 + 0.0161 * l * rates[1]) + pushed;
  return fourth * (rates[2] / 6.0 + 0.0738 * l * rates[1] + 0.0886 * l * l * rates[0]) + pushed;
}

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
    throw codegen::Error("a proof over a region of states takes plants with at most 3 of them");
  powers_ = all_powers<Powers>(static_cast<std::size_t>(nx), static_cast<int>(n) - 1);
  // Each corner has m^n_x unknowns. A cell lists its own state by state: those of the left end, then of the right one.
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
  // `to_polynomial` is off by some roundings of its own inverse, and its products by those of their sums.
  const double size = std::pow(to_polynomial.cwiseAbs().rowwise().sum().maxCoeff(), nx);
  error_ = gamma(100 * n * nx) * size * largest * 2.0;
}

Eigen::MatrixXcd ForwardSpline::fitted(const LatentMode& mode, const Matrix& x, const Matrix& z) const {
  constexpr double kRidge = 1e-14;  // of the largest: where (5) leaves T~ free, as beside an orbit that draws others in
  using Sparse = Eigen::SparseMatrix<std::complex<double>>;
  const Eigen::Index nx = plant_.nx(), n = 2 * shared_;
  const auto products = static_cast<Eigen::Index>(powers_.size());
  const Matrix to_polynomial = hermite(shared_);
  // The shapes that belong to a cell's unknowns in one state, at a distance from its centre; and their slopes.
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
  // Points of a cell: more of them than it has unknowns, so that nothing grows between them.
  const Eigen::Index side = n + 1;
  Matrix values(side, n), slopes(side, n);
  Vector at(side);
  for (Eigen::Index i = 0; i < side; ++i) {
    at(i) = std::cos(std::numbers::pi * static_cast<double>(i) / static_cast<double>(side - 1));
    values.row(i) = shapes(at(i));
    slopes.row(i) = shape_slopes(at(i));
  }
  const auto places = all_powers<Powers>(static_cast<std::size_t>(nx), static_cast<int>(side) - 1);
  std::vector<std::vector<Eigen::Index>> met(cells_.size());  // columns of x
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
    throw codegen::Error("no spline solves (5) over this region: the plant's equations have no values in a part of it");
  return solved;
}

ForwardSpline::Local ForwardSpline::local(const StateBox& box, const Vector& unit) const {
  const Eigen::Index nx = plant_.nx(), nz = system_.nz(), n = 2 * shared_;
  const Eigen::Index cell = region_.cell_of(box.centre);
  if (cell < 0) throw codegen::Error("a box outside of the region was asked for");
  const StateBox& own = cells_[static_cast<std::size_t>(cell)];
  Local local{coefficients_[static_cast<std::size_t>(cell)], Matrix(static_cast<Eigen::Index>(powers_.size()), nz)};
  const Vector largest = local.coefficients.cwiseAbs().colwise().maxCoeff();
  Matrix growth(n, nx);  // of errors of the coefficients, for each power of each state
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
  // Of a point, distances have any unit.
  Vector unit = box.radius;
  for (Eigen::Index p = 0; p < nx; ++p)
    if (unit(p) == 0.0) unit(p) = cells_[static_cast<std::size_t>(std::max<Eigen::Index>(cell, 0))].radius(p);
  const Local polynomial = local(box, unit);
  MapRanges ranges{IntervalMatrix(nz), IntervalMatrix(nz, nx), Vector::Zero(nz), IntervalMatrix(nz, nx)};
  // Of a product, and of its slopes: 0 where a factor is the distance from the centre of a box without width there.
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
