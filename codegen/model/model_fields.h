// SPDX-License-Identifier: MIT
// Reads parts of a model from its file (json_object.h writes them). Errors name the place in the file.
#pragma once

#include <nlo/latent.h>
#include <vector>

#include "codegen/base/json_field.h"
#include "codegen/model/network.h"

namespace nlo::codegen {

std::vector<Channel> channels(const Field& field);
DenseLayer dense(const Field& field);
Network network(const Field& field);
Hold hold(const Field& field);

}  // namespace nlo::codegen
