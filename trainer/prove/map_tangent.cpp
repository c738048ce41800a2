// SPDX-License-Identifier: MIT
#include "trainer/prove/map_tangent.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "codegen/model/activations.h"
#include "codegen/reference/reference_network.h"
#include "trainer/prove/map_region.h"
#include "trainer/prove/rounding.h"

namespace nlo::trainer {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Bounds the rounding of T* in double at one input, for each output.
Vector map_rounding(const codegen::Network& m, const Vector& in) {
  constexpr double kSteepest = 1.11;  // largest slope of all activations
  constexpr double kActivation = 2.0 * kLibraryUlps * kUnit;
  const Vector scale = m.feature_scale.cwiseInverse();
  const auto terms = [](const Matrix& w, const Vector& a, const Vector& b) {
    return Vector(gamma(w.cols() + 3) * (w.cwiseAbs() * a.cwiseAbs() + b.cwiseAbs()));
  };
  const Vector u = scale.cwiseProduct(m.features * in - m.feature_mean);
  const Vector u_error = scale.cwiseProduct(terms(m.features, in, m.feature_mean)) + 4.0 * kUnit * u.cwiseAbs();
  Vector a = u, error = u_error;
  const codegen::ActivationRow& activation = codegen::activation_row(m.activation);
  for (std::size_t l = 0; l < m.layers.size(); ++l) {
    const auto& [weights, bias] = m.layers[l];
    error = (weights.cwiseAbs() * error + terms(weights, a, bias)).eval();
    a = (weights * a + bias).eval();
    if (l + 1 == m.layers.size()) break;
    a = a.unaryExpr(activation.value).eval();
    error = kSteepest * error + kActivation * a.cwiseAbs();
  }
  if (m.skip.size() != 0) error += m.skip.cwiseAbs() * u_error + terms(m.skip, u, a);
  error = m.output_scale.cwiseProduct(error + 4.0 * kUnit * a.cwiseAbs()) + 4.0 * kUnit * m.output_mean.cwiseAbs();
  return 1.01 * error;
}

}  // namespace

MapTangent::MapTangent(const codegen::Network& map, const Matrix& inputs, const InputBox& box, const Vector& importance,
                       int pieces) {
  const codegen::ReferenceNetwork<double> reference(map);
  const Eigen::Index n = box.centre.size();
  const JacobianEnclosure enclosure(map, inputs, Matrix::Identity(n, n));
  struct Piece {
    InputBox box;
    Vector beside;
    Eigen::Index split;
  };
  const auto value_at = [&](const Vector& p) { return Vector(reference(inputs * p)); };
  value = value_at(box.centre);
  rounding = map_rounding(map, inputs * box.centre);
  const auto look = [&](const InputBox& at) {
    const JacobianEnclosure::Secants secants = enclosure.secants_over(at);
    if (slopes.size() == 0) slopes = secants.centre;
    const Vector distance = at.centre - box.centre;
    const Matrix turned = (secants.centre - slopes).cwiseAbs() + secants.radius;
    const Vector at_centre = distance.isZero(0.0)
                                 ? Vector(Vector::Zero(value.size()))
                                 : Vector((value_at(at.centre) - value - slopes * distance).cwiseAbs() +
                                          map_rounding(map, inputs * at.centre) + rounding +
                                          gamma(n + 2) * slopes.cwiseAbs() * distance.cwiseAbs());
    Piece piece{at, at_centre + turned * at.radius, 0};
    (importance.asDiagonal() * turned * piece.box.radius.asDiagonal()).colwise().sum().maxCoeff(&piece.split);
    return piece;
  };
  const auto urgency = [&](const Piece& piece) { return importance.dot(piece.beside); };
  const auto less = [&](const Piece& a, const Piece& b) { return urgency(a) < urgency(b); };
  std::vector<Piece> heap{look(box)};
  while (static_cast<int>(heap.size()) < pieces) {
    std::ranges::pop_heap(heap, less);
    const Piece largest = std::move(heap.back());
    heap.pop_back();
    for (const InputBox& half : halves(largest.box, largest.split)) {
      heap.push_back(look(half));
      std::ranges::push_heap(heap, less);
    }
  }
  beside = Vector::Zero(value.size());
  for (const Piece& piece : heap) beside = beside.cwiseMax(piece.beside);
}

}  // namespace nlo::trainer
