// SPDX-License-Identifier: MIT
#include "trainer/symmetry/kinds.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace nlo::trainer {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;

int below(int bound, const Uniform& uniform) {
  return std::min(bound - 1, static_cast<int>(uniform() * static_cast<float>(bound)));
}

Element scaled_by(double sign) {
  return {MatrixXd::Constant(1, 1, sign)};
}

Element draw_sign(int, int, const Uniform& uniform) {
  return scaled_by(uniform() < 0.5F ? -1.0 : 1.0);
}

std::vector<Element> other_sign(int, int) {
  return {scaled_by(-1.0)};
}

Element turned_by(double turns) {
  const double angle = 2.0 * std::numbers::pi * turns;
  const auto exact = [](double value) { return std::abs(value) < 1e-15 ? 0.0 : value; };  // of quarter turns
  const double c = exact(std::cos(angle)), s = exact(std::sin(angle));
  return {Eigen::Matrix2d{{c, -s}, {s, c}}, turns};
}

Element draw_turn(int, int fold, const Uniform& uniform) {
  return turned_by(fold > 0 ? static_cast<double>(below(fold, uniform)) / fold : static_cast<double>(uniform()));
}

std::vector<Element> other_turns(int, int fold) {
  const int parts = fold > 0 ? fold : 4;
  std::vector<Element> turns;
  for (int i = 1; i < parts; ++i) turns.push_back(turned_by(static_cast<double>(i) / parts));
  return turns;
}

/// A unit quaternion, uniform on the sphere (Shoemake 1992).
Element draw_rotation(int, int, const Uniform& uniform) {
  const double u = static_cast<double>(uniform()), a = 2.0 * std::numbers::pi * static_cast<double>(uniform()),
               b = 2.0 * std::numbers::pi * static_cast<double>(uniform());
  const double p = std::sqrt(1.0 - u), q = std::sqrt(u);
  const double x = p * std::sin(a), y = p * std::cos(a), z = q * std::sin(b), w = q * std::cos(b);
  return {Matrix3d{{1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)},
                   {2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)},
                   {2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)}}};
}

/// Those of a tetrahedron: half turns about the axes, after the axes have changed places in a circle.
std::vector<Element> other_rotations(int, int) {
  const Matrix3d circle{{0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
  std::vector<Element> rotations;
  Matrix3d turned = Matrix3d::Identity();
  for (int turn = 0; turn < 3; ++turn, turned = circle * turned)
    for (const Eigen::Vector3d& half : {Eigen::Vector3d(1, 1, 1), {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}})
      rotations.push_back({half.asDiagonal() * turned});
  rotations.erase(rotations.begin());  // the identity
  return rotations;
}

Element in_order(const std::vector<int>& order) {
  const auto n = static_cast<Eigen::Index>(order.size());
  Element element{MatrixXd::Zero(n, n)};
  for (Eigen::Index i = 0; i < n; ++i) element.matrix(i, order[static_cast<std::size_t>(i)]) = 1.0;
  return element;
}

/// Fisher and Yates.
Element draw_order(int components, int, const Uniform& uniform) {
  std::vector<int> order(static_cast<std::size_t>(components));
  std::iota(order.begin(), order.end(), 0);
  for (int i = components - 1; i > 0; --i)
    std::swap(order[static_cast<std::size_t>(i)], order[static_cast<std::size_t>(below(i + 1, uniform))]);
  return in_order(order);
}

std::vector<Element> other_orders(int components, int) {
  std::vector<int> order(static_cast<std::size_t>(components));
  std::iota(order.begin(), order.end(), 0);
  std::vector<Element> orders;
  for (int i = 1; i < components; ++i) {
    std::rotate(order.begin(), order.begin() + 1, order.end());
    orders.push_back(in_order(order));
  }
  return orders;
}

using Channels = SymmetryKind::Channels;

constexpr SymmetryKind kKinds[] = {
    {"sign", "channels turn their sign", kNoVectors, Channels::kScalars, draw_sign, other_sign},
    {"rotation2", "vectors of two turn, and channels, angles, move on", 2, Channels::kAngles, draw_turn, other_turns},
    {"rotation3", "vectors of three turn", 3, Channels::kNone, draw_rotation, other_rotations},
    {"permutation", "components of all vectors change places", kAnyLength, Channels::kNone, draw_order, other_orders},
    {"shift", "channels, angles, all move on", kNoVectors, Channels::kAngles, draw_turn, other_turns}};

}  // namespace

std::span<const SymmetryKind> symmetry_kinds() {
  return kKinds;
}

std::vector<std::string> symmetry_kind_names() {
  std::vector<std::string> names;
  for (const SymmetryKind& kind : kKinds) names.emplace_back(kind.name);
  return names;
}

const SymmetryKind& symmetry_kind(std::string_view name) {
  return *std::ranges::find(kKinds, name, &SymmetryKind::name);
}

}  // namespace nlo::trainer
