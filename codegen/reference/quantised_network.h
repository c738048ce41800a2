// SPDX-License-Identifier: MIT
// Networks in int16 with dynamic sizes: the results and the memory of runtime/include/nlo/quantised_map.h and
// quantised_units.h. codegen/fold/quantise.h makes these networks.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "codegen/model/activations.h"
#include "codegen/model/folded.h"

namespace nlo::codegen {

/// One layer: sum = bias + weights q, q in Q15, and |bias| + sum |weights| 32767 < 2^31 in every row.
struct QuantisedLayer {
  Eigen::Matrix<std::int16_t, Eigen::Dynamic, Eigen::Dynamic> weights;  ///< n_out x n_in
  Eigen::Matrix<std::int32_t, Eigen::Dynamic, 1> bias;                  ///< n_out
  int shift = 1;  ///< 1 to 31; sum / 2^shift is the argument in int16.h. Unused in the last layer
};

/// out = scale (integer layers)(saturate((in - centre) gain)) + linear_path in, then its fallback. If there are
/// products with clocks, `in` stands for [in; products].
struct QuantisedNetwork {
  Activation activation;         ///< kTanh (by table), kRelu or kSilu; after every layer but the last
  Eigen::VectorXf centre, gain;  ///< columns(); gain is 32767 / half of the input's range
  std::vector<QuantisedLayer> layers;
  Eigen::VectorXf scale;        ///< n_out; result per unit of the sums of the last layer
  Eigen::MatrixXf linear_path;  ///< n_out x columns(); 0 x 0: none
  std::vector<ClockProduct> products = {};
  Fallback fallback = {};  ///< as FoldedNetwork::fallback

  Eigen::Index columns() const { return centre.size(); }  ///< inputs and products
  Eigen::Index inputs() const { return columns() - static_cast<Eigen::Index>(products.size()); }
  Eigen::Index outputs() const { return scale.size(); }
};

/// The layers of gated units (codegen/model/gated.h). Each network has one layer, whose sums are arguments of tanh.
struct QuantisedUnits {
  QuantisedNetwork gates;      ///< [z; y] -> 2 n_z; centre and gain are those of y (n_r); z has centre 0 and gain 2^15
  QuantisedNetwork candidate;  ///< [g z; y] -> n_z; no centre, no gain
};

/// The parts of an observer in integers.
struct QuantisedModel {
  QuantisedNetwork map;                      ///< T*
  std::optional<QuantisedUnits> units = {};  ///< for structure gated
};

/// Returns the number of rows of a layer in the kernel, with the rows of zeros that complete its blocks of 4 and 5.
Eigen::Index padded_rows(Eigen::Index rows);

/// Returns the bytes of the nlo::QuantisedMap or nlo::QuantisedUnits of the network, padding included.
Eigen::Index packed_bytes(const QuantisedNetwork& network);

/// Returns the bits that nlo::QuantisedMap::evaluate gives on every target.
Eigen::VectorXf evaluate(const QuantisedNetwork& network, const Eigen::VectorXf& in);

/// Returns z (n_z) after one step of some sample periods, with the readings y (n_r) at its end: the bits that
/// nlo::QuantisedUnits::step gives. `regular`: the step is one sample period.
Eigen::VectorXf stepped(const QuantisedUnits& units, const Eigen::VectorXf& z, const Eigen::VectorXf& y, bool regular,
                        float periods);

}  // namespace nlo::codegen
