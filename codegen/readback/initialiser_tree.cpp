// SPDX-License-Identifier: MIT
#include "codegen/readback/initialiser_tree.h"

#include <algorithm>

#include "codegen/base/fail.h"

namespace nlo::codegen {

InitialiserTree initialiser(TokenStream& in) {
  InitialiserTree tree;
  tree.line = in.line();
  if (!in.accept("{")) {
    tree.leaf = in.take_until({",", ";", "}"});
    if (tree.leaf.empty()) fail("line {}: a value is missing", tree.line);
    return tree;
  }
  while (!in.accept("}")) {
    if (in.accept(".")) {
      tree.names.push_back(in.take().text);
      in.expect("=");
    }
    tree.children.push_back(initialiser(in));
    if (!in.at("}")) in.expect(",");
  }
  if (!tree.names.empty() && tree.names.size() != tree.children.size())
    fail("line {}: some values have a name and some have none", tree.line);
  return tree;
}

bool shape_of(const InitialiserTree& tree, std::size_t depth, std::vector<std::size_t>& shape) {
  if (tree.is_leaf()) return depth == shape.size();
  if (depth == shape.size()) shape.push_back(tree.children.size());
  return shape[depth] == tree.children.size() &&
         std::all_of(tree.children.begin(), tree.children.end(),
                     [&](const InitialiserTree& child) { return shape_of(child, depth + 1, shape); });
}

void values_of(const InitialiserTree& tree, std::vector<ReadValue>& values) {
  if (tree.is_leaf()) values.push_back({text_of(tree.leaf), tree.line, tree.leaf.front().at});
  for (const InitialiserTree& child : tree.children) values_of(child, values);
}

}  // namespace nlo::codegen
