// SPDX-License-Identifier: MIT
// What stands behind the = of a constant: braces within braces, or one expression.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "codegen/readback/read_text.h"
#include "codegen/readback/token_stream.h"

namespace nlo::codegen {

struct InitialiserTree {
  std::vector<InitialiserTree> children = {};
  std::vector<std::string> names = {};  ///< a designator for each child, or none at all
  std::vector<Token> leaf = {};         ///< where there are no braces
  int line = 0;

  bool is_leaf() const { return !leaf.empty(); }
};

InitialiserTree initialiser(TokenStream& in);

/// False when the braces at one depth differ in how many they hold.
bool shape_of(const InitialiserTree& tree, std::size_t depth, std::vector<std::size_t>& shape);

void values_of(const InitialiserTree& tree, std::vector<ReadValue>& values);

}  // namespace nlo::codegen
