// SPDX-License-Identifier: MIT
#include "trainer/prove/output_range.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <random>
#include <utility>

#include "codegen/model/domain.h"
#include "codegen/model/flown_ranges.h"
#include "codegen/reference/reference_network.h"
#include "codegen/structures/structure_module.h"
#include "trainer/prove/reachable_latent.h"
#include "trainer/prove/rounding.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Maximises |T*_i| by gradient ascent from random points, some of them corners, then by random draws around the best
/// point.
void climb(const codegen::Model& model, const MapRegion& region, Index output, std::uint64_t seed,
           LargestOutput& result) {
  constexpr int kStarts = 40, kRounds = 60;
  constexpr double kFirstStep = 0.5, kLastStep = 1e-6;
  const codegen::ReferenceNetwork<double> map(*codegen::inverse_map(model));
  const Index n = region.box.centre.size();
  const auto in_of = [&](const VectorXd& q) {
    return VectorXd(region.inputs * (region.box.centre + region.box.radius.cwiseProduct(q)));
  };
  std::mt19937_64 engine(seed);
  for (int start = 0; start < kStarts; ++start) {
    VectorXd q = VectorXd::NullaryExpr(n, [&] {
      const double u = static_cast<double>(engine() >> 11) * 0x1p-52 - 1.0;
      return start % 2 == 0 ? u : (u < 0.0 ? -1.0 : 1.0);
    });
    double value = std::abs(map(in_of(q))(output)), step = kFirstStep;
    for (int round = 0; round < kRounds && step > kLastStep; ++round) {
      const VectorXd in = in_of(q);
      const double sign = map(in)(output) < 0.0 ? -1.0 : 1.0;
      const VectorXd slope = sign * (map.jvp(in, region.inputs).row(output).transpose());
      const VectorXd uphill = slope.cwiseProduct(region.box.radius);
      const VectorXd to = round % 2 == 0 ? VectorXd(uphill.cwiseSign())
                                         : VectorXd(uphill / std::max(uphill.cwiseAbs().maxCoeff(), 1e-300));
      const VectorXd next = (q + step * to).cwiseMax(-1.0).cwiseMin(1.0);
      const double there = std::abs(map(in_of(next))(output));
      step *= there > value ? 1.5 : 0.6;
      if (!(there > value)) continue;
      q = next;
      value = there;
    }
    if (value <= result.found) continue;
    result.found = value;
    result.where = in_of(q);
  }
}

struct LeftBox {
  double bound;
  std::int64_t number;
  Index split;
  InputBox box;

  bool operator<(const LeftBox& other) const {
    return bound != other.bound ? bound < other.bound : number > other.number;
  }
};

}  // namespace

std::optional<MapRegion> reachable_region(const codegen::Model& model) {
  const Index nz = model.nz(), nr = readings_of_map(model);
  VectorXd low(nz + nr), high(nz + nr);
  low.tail(nr) = codegen::flown_ranges(model).kept_min.head(nr);
  high.tail(nr) = codegen::flown_ranges(model).kept_max.head(nr);
  const std::vector<codegen::Channel> channels = codegen::readings(model);
  for (Index j = 0; j < nr; ++j) {
    const double turn = channels[static_cast<std::size_t>(j)].wrap;
    if (turn == 0.0) continue;
    low(nz + j) = -0.5 * turn;
    high(nz + j) = 0.5 * turn;
  }
  if (const auto limit = codegen::module_of(model).latent_limit(model)) {
    low.head(nz) = -*limit;
    high.head(nz) = *limit;
    return region_between(model, low, high, false);
  }
  if (!moves_linearly(model)) return std::nullopt;
  const LatentHull hull = reachable_latent(model);
  low.head(nz) = hull.low;
  high.head(nz) = hull.high;
  if (!model.saturates()) return region_between(model, low, high, false);
  const codegen::LatentReach reach(model);
  const bool relative = codegen::saturates_relative(model);
  low.head(nz) = relative ? reach.min : VectorXd(low.head(nz).cwiseMax(reach.min).cwiseMin(reach.max));
  high.head(nz) = relative ? reach.max : VectorXd(high.head(nz).cwiseMin(reach.max).cwiseMax(reach.min));
  return region_between(model, low, high, relative);
}

LargestOutput largest_output(const codegen::Model& model, const MapRegion& region, Index output, std::int64_t boxes,
                             double gap, std::uint64_t seed) {
  LargestOutput result;
  result.where = region.inputs * region.box.centre;
  climb(model, region, output, seed, result);
  const Index n = region.box.centre.size();
  const JacobianEnclosure enclosure(*codegen::inverse_map(model), region.inputs, Eigen::MatrixXd::Identity(n, n));
  std::priority_queue<LeftBox> left;
  const auto look_at = [&](const InputBox& box, double parent) {
    const JacobianEnclosure::Values values = enclosure.values_over(box);
    const double bound = std::max(std::abs(values.low(output)), std::abs(values.high(output)));
    left.push({std::min(parent, bound), result.boxes++, values.split, box});
  };
  look_at(region.box, std::numeric_limits<double>::infinity());
  while (left.top().bound > result.found * (1.0 + gap) && result.boxes + 2 <= boxes) {
    const LeftBox widest = left.top();
    left.pop();
    for (const InputBox& half : halves(widest.box, widest.split)) look_at(half, widest.bound);
  }
  result.bound = left.top().bound;
  return result;
}

}  // namespace nlo::trainer
