// SPDX-License-Identifier: MIT
#include "codegen/model/activations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace nlo::codegen {
namespace {

/// Formulas of the value and the slope, for a number and for an array. Every activation that can be trained has one; a
/// row without it does not compile.
template <Activation kKind>
struct Formula;

template <>
struct Formula<Activation::kTanh> {
  template <class V>
  static auto value(const V& v) {
    using std::tanh;
    return tanh(v);
  }
  template <class Scalar, class V>
  static auto slope(const V&, const V& a) {
    return Scalar(1) - a * a;
  }
};

template <>
struct Formula<Activation::kRelu> {
  static double value(double v) { return std::max(v, 0.0); }
  template <class V>
  static auto value(const V& v) {
    return v.max(typename V::Scalar(0));
  }
  template <class Scalar>
  static double slope(double v, double) {
    return v > 0.0 ? 1.0 : 0.0;
  }
  template <class Scalar, class V>
  static auto slope(const V& v, const V&) {
    return (v > Scalar(0)).template cast<Scalar>();
  }
};

template <>
struct Formula<Activation::kSilu> {
  static double value(double v) { return v / (1.0 + std::exp(-v)); }
  template <class V>
  static auto value(const V& v) {
    return v / (typename V::Scalar(1) + (-v).exp());
  }
  template <class Scalar>
  static double slope(double v, double a) {
    const double s = 1.0 / (1.0 + std::exp(-v));
    return s + a * (1.0 - s);
  }
  template <class Scalar, class V>
  static ActivationArray<Scalar> slope(const V& v, const V& a) {
    const ActivationArray<Scalar> s = Scalar(1) / (Scalar(1) + (-v).exp());
    return s + a * (Scalar(1) - s);
  }
};

}  // namespace

namespace activation_functions {

double tanh(double v) {
  return Formula<Activation::kTanh>::value(v);
}
double tanh_slope(double v) {
  return Formula<Activation::kTanh>::slope<double>(v, tanh(v));
}
double tanh_curvature(double v) {
  return -2.0 * tanh(v) * tanh_slope(v);
}

double relu(double v) {
  return Formula<Activation::kRelu>::value(v);
}
double relu_slope(double v) {
  return Formula<Activation::kRelu>::slope<double>(v, relu(v));
}
double relu_curvature(double) {
  return 0.0;
}

double silu(double v) {
  return Formula<Activation::kSilu>::value(v);
}
double silu_slope(double v) {
  return Formula<Activation::kSilu>::slope<double>(v, silu(v));
}
/// Returns s (1 - s) (2 + v (1 - 2 s)), s = sigmoid(v).
double silu_curvature(double v) {
  const double s = 1.0 / (1.0 + std::exp(-v));
  return s * (1.0 - s) * (2.0 + v * (1.0 - 2.0 * s));
}

}  // namespace activation_functions

const ActivationRow* find_activation(std::string_view name) {
  for (const ActivationRow& row : kActivations)
    if (row.name == name && row.is_trained()) return &row;
  return nullptr;
}

const ActivationRow& activation_named(std::string_view name) {
  if (const ActivationRow* row = find_activation(name)) return *row;
  throw Error(fmt::format("unknown activation \"{}\"; use {}", name, activations_in_words()));
}

std::vector<std::string> activation_names() {
  std::vector<std::string> names;
  for (const ActivationRow& row : kActivations)
    if (row.is_trained()) names.emplace_back(row.name);
  return names;
}

std::string activations_in_words() {
  const std::vector<std::string> names = activation_names();
  std::string words = names.front();
  for (std::size_t i = 1; i < names.size(); ++i) words += (i + 1 < names.size() ? ", " : " or ") + names[i];
  return words;
}

template <class Scalar>
ActivationArray<Scalar> activated(Activation kind, const Eigen::Ref<const ActivationArray<Scalar>>& v) {
  return with_trained_activation(activation_row(kind).trained_as,
                                 [&](auto trained) -> ActivationArray<Scalar> { return Formula<trained()>::value(v); });
}

template <class Scalar>
ActivationArray<Scalar> activation_slopes(Activation kind, const Eigen::Ref<const ActivationArray<Scalar>>& v,
                                          const Eigen::Ref<const ActivationArray<Scalar>>& a) {
  return with_trained_activation(activation_row(kind).trained_as, [&](auto trained) -> ActivationArray<Scalar> {
    return Formula<trained()>::template slope<Scalar>(v, a);
  });
}

using Floats = ActivationArray<float>;
using Doubles = ActivationArray<double>;
template Floats activated<float>(Activation, const Eigen::Ref<const Floats>&);
template Doubles activated<double>(Activation, const Eigen::Ref<const Doubles>&);
template Floats activation_slopes<float>(Activation, const Eigen::Ref<const Floats>&, const Eigen::Ref<const Floats>&);
template Doubles activation_slopes<double>(Activation, const Eigen::Ref<const Doubles>&,
                                           const Eigen::Ref<const Doubles>&);

void activation_rows::refuse_untrained(Activation kind) {
  const bool known = static_cast<std::size_t>(kind) < kActivations.size();
  throw Error(fmt::format("{} can only be chosen by an export, not for training; use {}",
                          known ? activation_row(kind).identifier : "an unknown activation", activations_in_words()));
}

}  // namespace nlo::codegen
