// SPDX-License-Identifier: MIT
// Objects of the C interface that are freed at the end of a scope.
#pragma once

#include <memory>
#include <string>

#include "bindings/c/nlo_model.h"

namespace nlo::codegen {

struct Free {
  void operator()(nlo_model* model) const { nlo_model_free(model); }
  void operator()(nlo_observer* observer) const { nlo_observer_free(observer); }
};
using ModelPointer = std::unique_ptr<nlo_model, Free>;
using ObserverPointer = std::unique_ptr<nlo_observer, Free>;

inline ModelPointer loaded(const std::string& json) {
  return ModelPointer(nlo_model_from_bytes(json.data(), json.size()));
}

}  // namespace nlo::codegen
