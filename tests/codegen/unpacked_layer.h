// SPDX-License-Identifier: MIT
// Converts an integer layer of the runtime into the form of the exporter.
#pragma once

#include <nlo/quantised_map.h>

#include "codegen/reference/quantised_network.h"

namespace nlo::codegen {

template <class Packed>
QuantisedLayer unpacked(const Packed& packed) {
  QuantisedLayer layer{{}, {}, Packed::kShift};
  layer.weights.resize(Packed::kOut, Packed::kIn);
  layer.bias.resize(Packed::kOut);
  for (int o = 0; o < Packed::kOut; ++o) {
    layer.bias(o) = packed.bias[o];
    for (int i = 0; i < Packed::kIn; ++i)
      layer.weights(o, i) = packed.weights[kernels::int16::weight_position<Packed::kIn, Packed::kOut>(o, i)];
  }
  return layer;
}

}  // namespace nlo::codegen
