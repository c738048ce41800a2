// SPDX-License-Identifier: MIT
// A folded network as C++: its layers as constants, its type, its initialiser, and its cost.
#pragma once

#include <Eigen/Core>
#include <string>

#include "codegen/model/folded.h"
#include "codegen/reference/quantised_network.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {

/// One network of a generated header; in int16 if `quantised` is set.
struct CppNetwork {
  const FoldedNetwork& network;
  std::string field;  ///< its name in the model, for messages: "inverse_map"
  std::string layer;  ///< name of its layers: "Layer" for weights::kLayer1, ...
  std::string type;   ///< C++ type of the network: "Network"
  std::string reads;  ///< its inputs: "[z; y]"
  const QuantisedNetwork* quantised = nullptr;
  const FoldedErrorHead* error = nullptr;  ///< error head of T*, if any

  bool has_linear_path() const { return network.linear_path.size() != 0; }
  bool has_products() const { return !network.products.empty(); }
  bool has_fallback() const { return !network.fallback.outputs.empty(); }

  /// Returns the constants kLayer1, ... with a comment each, for the namespace weights.
  std::string layers(const Initialiser& init) const;

  /// Returns `using Network = decltype(make_mlp<...>(weights::kLayer1, ...));`.
  std::string using_declaration() const;

  /// Returns `LearnedMap<Network, LinearPath<float, 3, 2>>`. The optional parts after the network are the linear path,
  /// the error head, the products with clocks and the fallback.
  std::string map_type(const Initialiser& init) const;

  /// Returns `    .inverse_map = {...},`.
  std::string initialiser(const Initialiser& init, const std::string& member) const;

  /// Returns "3-50-50-2 tanh and a linear path, reads z".
  std::string description() const;

  Eigen::Index multiply_adds() const;  ///< without the error head
  Eigen::Index activations() const;
  Eigen::Index constant_bytes(const Initialiser& init) const;

 private:
  std::string made() const;  ///< `make_mlp<...>(weights::kLayer1, ...)`
};

}  // namespace nlo::codegen
