// SPDX-License-Identifier: MIT
#include "trainer/prove/lipschitz.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <queue>
#include <random>
#include <string_view>
#include <utility>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/base/linear_algebra.h"
#include "codegen/model/domain.h"
#include "codegen/reference/reference_network.h"
#include "codegen/replay/reference_observer.h"
#include "trainer/prove/activation_slope.h"
#include "trainer/prove/jacobian_enclosure.h"
#include "trainer/prove/map_region.h"
#include "trainer/prove/rounding.h"

namespace nlo::trainer {

double spectral_norm(const Eigen::MatrixXd& matrix) {
  if (matrix.size() == 0) return 0.0;
  return codegen::singular_values(matrix)(0);
}

Eigen::MatrixXd inverse_map_jacobian(const codegen::Model& model, const Eigen::VectorXd& z, const Eigen::VectorXd& y) {
  const codegen::Network& map = *codegen::inverse_map(model);
  Eigen::VectorXd input(z.size() + y.size());
  input << z, y;
  const Eigen::MatrixXd directions = Eigen::MatrixXd::Identity(map.inputs(), map.inputs());
  return codegen::ReferenceNetwork<double>(map).jvp(input, directions);
}

LipschitzConstants lipschitz_sampled(const codegen::Model& model, const Eigen::MatrixXd& z, const Eigen::MatrixXd& y) {
  LipschitzConstants result;
  const bool reads_output = !codegen::inverse_map(model)->features.rightCols(readings_of_map(model)).isZero(0.0);
  for (Eigen::Index b = 0; b < z.cols(); ++b) {
    const Eigen::MatrixXd jacobian = inverse_map_jacobian(model, z.col(b), y.col(b));
    result.latent = std::max(result.latent, spectral_norm(jacobian.leftCols(model.nz())));
    if (reads_output)
      result.output = std::max(result.output, spectral_norm(jacobian.rightCols(readings_of_map(model))));
  }
  return result;
}

namespace {

/// The domain of T*, and the directions of its input p that change only z or only y.
struct Domain {
  InputBox box;
  Eigen::MatrixXd inputs, directions;
};

Domain domain_of(const codegen::Model& model, bool of_output) {
  const Eigen::Index nz = model.nz(), nr = readings_of_map(model), n = nz + nr;
  const MapRegion region = domain_region(model);
  Domain domain{region.box, region.inputs, Eigen::MatrixXd::Identity(n, n)};
  if (of_output) {  // only y moves: z = p_z + S y must not change
    domain.directions.topRightCorner(nz, nr) = -domain.inputs.topRightCorner(nz, nr);
    domain.directions = domain.directions.rightCols(nr).eval();
  } else {
    domain.directions = domain.directions.leftCols(nz).eval();
  }
  return domain;
}

double slope_at(const codegen::Model& model, bool of_output, const Eigen::VectorXd& in) {
  const Eigen::MatrixXd jacobian = inverse_map_jacobian(model, in.head(model.nz()), in.tail(readings_of_map(model)));
  return spectral_norm(of_output ? jacobian.rightCols(readings_of_map(model)) : jacobian.leftCols(model.nz()));
}

/// Returns the number of balancing rounds, such that balancing takes at most a fifth of the work; at most ten.
int balancing_rounds(const codegen::Network& network, double cost) {
  constexpr double kMost = 10.0, kShare = 0.2, kTrials = 2.0;  // per neuron
  double neurons = 0.0;
  for (const codegen::DenseLayer& layer : network.layers) neurons += static_cast<double>(layer.weights.rows());
  return static_cast<int>(std::min(kMost, kShare * LocalLipschitzOptions::kMultiplyAdds / (kTrials * neurons * cost)));
}

/// A box that is still open, ordered by its bound. Among equal bounds the older box comes first, so that the order is
/// unique.
struct Candidate {
  double bound;
  std::int64_t number;
  Eigen::Index split;
  bool by_norms;
  InputBox box;

  bool operator<(const Candidate& other) const {
    return bound != other.bound ? bound < other.bound : number > other.number;
  }
};

}  // namespace

LocalLipschitz steepest_slope(const codegen::Model& model, bool of_output, int starts, const Eigen::MatrixXd& points) {
  constexpr int kRounds = 60, kDraws = 120;
  constexpr double kDifference = 1e-6, kFirstStep = 0.2, kLastStep = 1e-5;  // steps in half widths of the box
  constexpr double kMomentum = 0.7;
  const Domain domain = domain_of(model, of_output);
  const Eigen::Index n = domain.box.centre.size();
  std::mt19937_64 engine(1);
  const auto slope = [&](const Eigen::VectorXd& q) {
    return slope_at(model, of_output, domain.inputs * (domain.box.centre + domain.box.radius.cwiseProduct(q)));
  };
  const auto draw = [&] {
    return Eigen::VectorXd(Eigen::VectorXd::NullaryExpr(
        n, [&] { return static_cast<double>(static_cast<std::int64_t>(engine())) * 0x1p-63; }));
  };
  Eigen::VectorXd first = Eigen::VectorXd::Zero(n);  // the centre, or the steepest point
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::VectorXd away = codegen::inverse(domain.inputs) * points.col(i) - domain.box.centre;
    // Relative to the half widths. An input without width, such as y if T* does not read it, does not move.
    const Eigen::VectorXd q = (domain.box.radius.array() > 0.0).select(away.cwiseQuotient(domain.box.radius), 0.0);
    if (q.lpNorm<Eigen::Infinity>() > 1.0) continue;
    if (slope(q) > slope(first)) first = q;
  }
  LocalLipschitz best;
  best.steepest = domain.inputs * domain.box.centre;
  for (int start = 0; start < starts; ++start) {
    Eigen::VectorXd q = start == 0 ? first : draw();
    Eigen::VectorXd direction = Eigen::VectorXd::Zero(n);
    double value = slope(q), step = kFirstStep;
    for (int round = 0; round < kRounds && step > kLastStep; ++round) {
      Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n);
      for (Eigen::Index k = 0; k < n; ++k) {
        if (domain.box.radius(k) == 0.0) continue;
        Eigen::VectorXd beside = q;
        beside(k) += kDifference;
        gradient(k) = slope(beside) - value;
        if (std::abs(q(k)) == 1.0 && gradient(k) * q(k) > 0.0) gradient(k) = 0.0;  // the box ends here
      }
      const double size = gradient.lpNorm<Eigen::Infinity>();
      if (!(size > 0.0)) break;
      direction = kMomentum * direction + gradient / size;  // follows a ridge instead of crossing it
      const Eigen::VectorXd next =
          (q + step / direction.lpNorm<Eigen::Infinity>() * direction).cwiseMax(-1.0).cwiseMin(1.0);
      const double there = slope(next);
      step *= there > value ? 1.3 : 0.5;
      if (!(there > value)) {
        direction.setZero();
        continue;
      }
      q = next;
      value = there;
    }
    // Where two singular values meet, the norm has a kink. Gradients do not lead along a kink, but random draws can
    // follow it.
    step = kFirstStep;
    for (int i = 0; i < kDraws && step > kLastStep; ++i) {
      const Eigen::VectorXd next = (q + step * draw()).cwiseMax(-1.0).cwiseMin(1.0);
      const double there = slope(next);
      step *= there > value ? 1.5 : 0.9;
      if (!(there > value)) continue;
      q = next;
      value = there;
    }
    if (value <= best.found) continue;
    best.found = value;
    best.steepest = domain.inputs * (domain.box.centre + domain.box.radius.cwiseProduct(q));
  }
  return best;
}

LocalLipschitz local_lipschitz(const codegen::Model& model, bool of_output, const LocalLipschitzOptions& options) {
  constexpr int kStarts = 32;
  const LipschitzConstants everywhere = lipschitz_upper(model);
  const double global = of_output ? everywhere.output : everywhere.latent;
  LocalLipschitz result = steepest_slope(model, of_output, kStarts, options.points);
  if (of_output && global == 0.0) return result;  // T* does not read y

  const Domain domain = domain_of(model, of_output);
  JacobianEnclosure enclosure(*codegen::inverse_map(model), domain.inputs, domain.directions);
  enclosure.balance(domain.box, balancing_rounds(*codegen::inverse_map(model), enclosure.cost()));
  const std::int64_t most =
      options.boxes > 0
          ? options.boxes
          : std::max<std::int64_t>(1, static_cast<std::int64_t>(options.multiply_adds / enclosure.cost()));
  std::priority_queue<Candidate> left;
  const auto look_at = [&](InputBox box, double parent, bool by_norms) {
    const JacobianEnclosure::Bound bound = enclosure.over(box, by_norms);
    const double centre = enclosure.at(box.centre);
    if (centre > result.found) {
      result.found = centre;
      result.steepest = domain.inputs * box.centre;
    }
    left.push({std::min(parent, bound.norm), result.boxes++, bound.split, bound.by_norms, std::move(box)});
  };
  look_at(domain.box, global, true);
  while (left.top().bound > result.found * (1.0 + options.gap) && result.boxes + 2 <= most) {
    const Candidate widest = left.top();
    left.pop();
    for (const InputBox& half : halves(widest.box, widest.split)) look_at(half, widest.bound, widest.by_norms);
  }
  result.bound = left.top().bound;
  if (result.found > result.bound * (1.0 + 1e-9))
    throw codegen::Error(
        fmt::format("the slope of T* is {} at a point of its domain, which is above its proven bound {}: this is a "
                    "defect of nlo, please report it",
                    result.found, result.bound));
  return result;
}

}  // namespace nlo::trainer
