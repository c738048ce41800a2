// SPDX-License-Identifier: MIT
#include "trainer/prove/steady_error.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <queue>
#include <utility>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/model/domain.h"
#include "codegen/model/latent_step.h"
#include "trainer/prove/forward_spline.h"
#include "trainer/prove/latent_memory.h"
#include "trainer/prove/map_region.h"
#include "trainer/prove/map_tangent.h"
#include "trainer/prove/region_maxima.h"
#include "trainer/prove/rounding.h"

namespace nlo::trainer {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// A box of the region and its bounds.
struct Examined {
  StateBox box;
  Vector bound;   ///< n_x
  Vector centre;  ///< the bound at the centre alone
  Vector moved;   ///< part of the bound from the width of the box, n_x
  Vector bent;    ///< part of the bound from the distance of T* from its tangent, n_x
  Eigen::Index split = 0;
  int pieces = 1;  ///< number of pieces into which T* was divided in this box
  double urgency = 0.0;

  bool operator<(const Examined& other) const { return urgency < other.urgency; }
};

class Proof {
 public:
  Proof(const codegen::Model& model, const PlantConfig& plant, const StateRegion& region, const SteadyStates& states,
        const SteadyQuestion& question)
      : model_(model),
        map_(*codegen::inverse_map(model)),
        plant_(plant),
        region_(region),
        coarse_(region.coarser(kMostSplineCells)),
        states_(states),
        question_(question),
        system_(latent_system(model)),
        memory_(model),
        largest_(plant_.nx(), plant_.ny(), model.nz()),
        reads_output_(!map_.features.rightCols(model.ny()).isZero(0.0)) {}

  SteadyError result() {
    spline_ = std::make_unique<ForwardSpline>(plant_, system_, coarse_, HoldEffect(model_.hold, model_.sample_period_s),
                                              states_.x, states_.z);
    bound_residual();
    SteadyError result;
    const auto [bound, where, boxes] = search(question_.noise, question_.disturbance);
    result.bound = bound;
    result.where = where;
    result.boxes = boxes;
    result.approximation = std::get<0>(search(0.0, 0.0));
    result.residual = largest_.residual.norm() / (system_.injection.cwiseAbs() * largest_.rates[0]).norm();
    return result;
  }

 private:
  /// Halves cells until the residual's bound over each cell is at most kEnough |F y|, or kMostHalvings is reached.
  void bound_residual() {
    constexpr double kEnough = 1e-5;  // relative to |F y|
    constexpr int kMostHalvings = 6;
    std::vector<StateBox> left = region_.cells();
    for (int halving = 0; !left.empty(); ++halving) {
      std::vector<StateBox> next;
      for (const StateBox& box : left) {
        const Vector bound = spline_->residual(box);
        const PlantRanges plant = plant_.over(box);
        const double size = (system_.injection.cwiseAbs() * plant.rates[0].largest()).norm();
        if (halving < kMostHalvings && !(bound.norm() <= kEnough * size)) {
          for (const StateBox& half : halves(box, halving % plant_.nx())) next.push_back(half);
          continue;
        }
        if (!bound.allFinite())
          throw codegen::Error("the plant's equations have no value in a part of the region; give a smaller --box");
        largest_.residual = largest_.residual.cwiseMax(bound);
        largest_.take(plant, spline_->over(box));
      }
      left = std::move(next);
    }
  }

  /// Bounds how far z - T~(x) can move in a step without the noise: |d| of each row.
  Vector step_error(double disturbance) const {
    constexpr double kCoefficients = 1e-13;  // relative error of the coefficients of a step
    const double dt = model_.sample_period_s;
    codegen::Model exact = model_;
    if (exact.hold == Hold::kRk4) exact.hold = Hold::kFirstOrder;
    const codegen::StepMatrices of_hold = codegen::latent_step(exact, dt);
    const Matrix a = codegen::block_diagonal(exact, of_hold.a_minus_1) + Matrix::Identity(model_.nz(), model_.nz());
    const Vector off = ((memory_.a - a).cwiseAbs() + kCoefficients * a.cwiseAbs()) * largest_.map +
                       ((memory_.b0 - of_hold.b0).cwiseAbs() + (memory_.b1 - of_hold.b1).cwiseAbs() +
                        kCoefficients * (of_hold.b0.cwiseAbs() + of_hold.b1.cwiseAbs())) *
                           largest_.rates[0];
    Vector result(model_.nz());
    for (const LatentMode& mode : modes_of(system_)) {
      const double rate = -mode.lambda.real();
      const double span = rate > 0.0 ? -std::expm1(-rate * dt) / rate : dt;  // integral of exp(-rate s)
      double injected = 0.0;
      for (Eigen::Index j = 0; j < plant_.ny(); ++j) {
        std::array<double, 3> rates{}, pushes{};
        for (std::size_t i = 0; i < 3; ++i) {
          rates[i] = largest_.rates[i + 1](j);
          pushes[i] = disturbance * largest_.rate_slopes[i].row(j).sum();
        }
        injected += std::abs(mode.f(j)) * HoldEffect::left_over(model_.hold, dt, std::abs(mode.lambda), rates, pushes);
      }
      const auto norm_of = [&](const auto& rows) { return rows.segment(mode.row, mode.rows).norm(); };
      const Vector pushed = disturbance * largest_.map_slopes.rowwise().sum();
      const double moved = span * (norm_of(largest_.residual) + norm_of(pushed)) + injected + norm_of(off);
      for (Eigen::Index r = 0; r < mode.rows; ++r) result(mode.row + r) = moved * (1.0 + 1e-12);
    }
    return result;
  }

  /// Bounds z - T~(x) in the directions that the noise drives most.
  void enclose_latent_error(const Vector& noise, const Vector& step) {
    const Matrix weighted = memory_.noise * noise(0);
    const Eigen::SelfAdjointEigenSolver<Matrix> principal(weighted * weighted.transpose() +
                                                          Matrix(step.cwiseAbs2().asDiagonal()) * 1e-6 +
                                                          Matrix::Identity(model_.nz(), model_.nz()) * 1e-300);
    axes_ = principal.eigenvectors();
    reach_ = memory_.largest(axes_.transpose(), noise, step);
  }

  Examined examine(StateBox box, const Vector& noise, const Vector& step, int pieces) const {
    const Eigen::Index nx = plant_.nx(), ny = plant_.ny(), nz = model_.nz();
    const MapRanges map = spline_->over(box);
    const PlantRanges at = plant_.over({box.centre, Vector::Zero(nx)}), plant = plant_.over(box);
    const Vector z = map.at_centre.middle(), y = at.rates[0].middle();
    Matrix inputs = Matrix::Zero(nz + ny, nx + nz + ny);
    const Matrix slopes = map.slopes_at_centre.middle(), h_slopes = at.rate_slopes[0].middle();
    inputs.topLeftCorner(nz, nx) = slopes;
    inputs.block(0, nx, nz, nz) = axes_;
    inputs.bottomLeftCorner(ny, nx) = h_slopes;
    inputs.bottomRightCorner(ny, ny).setIdentity();
    InputBox around{Vector::Zero(nx + nz + ny), Vector::Zero(nx + nz + ny)};
    around.centre.segment(nx, nz) = axes_.transpose() * z;
    around.centre.tail(ny) = y;
    // Distances of T~ and h from their tangents at the centre, and their rounding errors.
    const Vector beside = map.bent + map.at_centre.radius() + map.slopes_at_centre.radius() * box.radius +
                          Vector::Constant(nz, gamma(4 * nz + 16) * (1.0 + z.norm()));
    const Vector h_beside = h_bent(plant, h_slopes) * box.radius + at.rates[0].radius() +
                            Vector::Constant(ny, gamma(16) * (1.0 + y.norm()));
    around.radius.head(nx) = box.radius;
    around.radius.segment(nx, nz) = reach_ + axes_.transpose().cwiseAbs() * beside;
    around.radius.tail(ny) = noise + h_beside;
    check_range(z, y, around, inputs);

    const MapTangent tangent(map_, inputs, around, importance_, pieces);
    const Matrix along_x = tangent.slopes.leftCols(nx) - Matrix::Identity(nx, nx);
    const Matrix along_e = tangent.slopes.middleCols(nx, nz), along_y = tangent.slopes.rightCols(ny);
    const Vector off = (tangent.value - box.centre).cwiseAbs() + tangent.rounding;
    const Vector driven = memory_.largest(along_e * axes_.transpose(), noise, step,
                                          reads_output_ ? along_y : Matrix(Matrix::Zero(nx, ny)));
    Examined result{std::move(box), {}, off + driven, along_x.cwiseAbs() * around.radius.head(nx),
                    tangent.beside, 0,  pieces};
    result.bound =
        upward(result.centre + result.moved + result.bent +
                   (along_e.cwiseAbs() * axes_.transpose().cwiseAbs()) * beside + along_y.cwiseAbs() * h_beside,
               64 * (nz + ny + nx));
    Eigen::Index worst = 0;
    result.bound.cwiseQuotient(result.centre.cwiseMax(1e-300)).maxCoeff(&worst);
    along_x.row(worst).transpose().cwiseAbs().cwiseProduct(result.box.radius).maxCoeff(&result.split);
    return result;
  }

  /// Returns a bound of |dh/dx - its value at the centre| over the box.
  static Matrix h_bent(const PlantRanges& plant, const Matrix& at_centre) {
    Matrix bent(at_centre.rows(), at_centre.cols());
    for (Eigen::Index i = 0; i < bent.rows(); ++i)
      for (Eigen::Index j = 0; j < bent.cols(); ++j)
        bent(i, j) = most(plant.rate_slopes[0](i, j) - Interval(at_centre(i, j)));
    return bent;
  }

  /// Checks that measurements are within their ranges and, for a saturating T*, latent states too, because only then
  /// the model uses them unchanged.
  void check_range(const Vector& z, const Vector& y, const InputBox& around, const Matrix& inputs) const {
    const Vector reach = inputs.cwiseAbs() * around.radius;
    const Eigen::Index nz = z.size(), ny = y.size();
    for (Eigen::Index j = 0; j < ny; ++j)
      if (y(j) - reach(nz + j) < model_.output_min(j) || y(j) + reach(nz + j) > model_.output_max(j))
        throw codegen::Error(fmt::format(
            "output {} reaches {:.4g} in this region with this noise, which is outside of the observer's range "
            "[{:.4g}, {:.4g}]; give less --noise or a smaller --box",
            model_.outputs[static_cast<std::size_t>(j)].name, y(j) + (y(j) > 0.0 ? reach(nz + j) : -reach(nz + j)),
            model_.output_min(j), model_.output_max(j)));
    if (!model_.saturates()) return;
    const codegen::LatentReach limits(model_);
    for (Eigen::Index r = 0; r < nz; ++r)
      if (z(r) - reach(r) < limits.min(r) || z(r) + reach(r) > limits.max(r))
        throw codegen::Error(fmt::format(
            "latent state {} leaves the range that T* reads in this region with this noise; give less --noise, less "
            "--disturbance or a smaller --box",
            r));
  }

  std::tuple<Vector, Matrix, std::int64_t> search(double noise_size, double disturbance) {
    constexpr double kGap = 1.02, kWorthIt = 0.999;
    constexpr int kMostPieces = 1024;
    const Vector noise = Vector::Constant(plant_.ny(), noise_size), step = step_error(disturbance);
    enclose_latent_error(noise, step);
    importance_ = map_.output_scale.cwiseInverse();
    const Eigen::Index nx = plant_.nx();
    Vector target = Vector::Zero(nx), bound = target;
    Matrix where = Matrix::Zero(nx, nx);
    const auto settle = [&](const Examined& box) {
      for (Eigen::Index i = 0; i < nx; ++i) {
        if (box.bound(i) <= bound(i)) continue;
        bound(i) = box.bound(i);
        where.col(i) = box.box.centre;
      }
    };
    const auto urgency = [&](const Examined& box) { return box.bound.cwiseQuotient(target).maxCoeff(); };
    std::vector<Examined> first;
    std::int64_t looked_at = 0;
    for (StateBox& cell : region_.cells()) {
      first.push_back(examine(std::move(cell), noise, step, 1));
      target = target.cwiseMax(first.back().centre);
      ++looked_at;
    }
    std::priority_queue<Examined> left;
    for (Examined& box : first) {
      box.urgency = urgency(box);
      left.push(std::move(box));
    }
    while (!left.empty()) {
      const Examined box = left.top();
      left.pop();
      if (box.urgency <= kGap || looked_at >= question_.boxes) {
        settle(box);
        continue;
      }
      std::vector<Examined> next;
      Eigen::Index worst = 0;
      box.bound.cwiseQuotient(target).maxCoeff(&worst);
      if (box.bent(worst) > box.moved(worst)) {
        if (box.pieces < kMostPieces) next.push_back(examine(box.box, noise, step, 2 * box.pieces));
        looked_at += box.pieces * 2;
      } else {
        for (const StateBox& half : halves(box.box, box.split)) next.push_back(examine(half, noise, step, box.pieces));
        looked_at += 2 * box.pieces;
      }
      bool better = false;
      for (Examined& box_of : next) {
        target = target.cwiseMax(box_of.centre);
        box_of.urgency = urgency(box_of);
        better = better || box_of.urgency < kWorthIt * box.urgency;
      }
      if (!better) settle(box);
      for (Examined& child : next)
        if (better) left.push(std::move(child));
    }
    return {bound, where, looked_at};
  }

  const codegen::Model& model_;
  const codegen::Network& map_;
  PlantEnclosure plant_;
  static constexpr std::size_t kMostSplineCells = 400;

  const StateRegion& region_;
  StateRegion coarse_;  ///< region of the spline
  const SteadyStates& states_;
  SteadyQuestion question_;
  LatentSystem system_;
  LatentMemory memory_;
  RegionMaxima largest_;
  bool reads_output_;
  std::unique_ptr<ForwardSpline> spline_;
  Matrix axes_;        ///< orthogonal: z - T~(x) = axes g
  Vector reach_;       ///< |g|
  Vector importance_;  ///< weights of the states' errors, 1 / their sizes
};

}  // namespace

SteadyError steady_error(const codegen::Model& model, const PlantConfig& plant, const StateRegion& region,
                         const SteadyStates& states, const SteadyQuestion& question) {
  return Proof(model, plant, region, states, question).result();
}

}  // namespace nlo::trainer
