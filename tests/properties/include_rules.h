// SPDX-License-Identifier: MIT
// Allowed directions of includes: arrows between the parts, walls within them, exceptions. include_arrows_test.cpp
// checks each file.
#pragma once

#include <string_view>
#include <vector>

namespace nlo::properties {

/// Allowed includes. The longest `from` that a file's path starts with applies; its `may` lists prefixes of targets.
struct Arrow {
  std::string_view from;
  std::vector<std::string_view> may;
};

inline const std::vector<Arrow> kArrows = {
    {"runtime/", {"nlo/"}},
    {"codegen/", {"nlo/", "codegen/"}},
    // Folders of the generator, as in their READMEs.
    {"codegen/base/", {"codegen/base/"}},
    {"codegen/model/", {"nlo/", "codegen/base/", "codegen/model/"}},
    {"codegen/reference/", {"nlo/", "codegen/base/", "codegen/model/", "codegen/reference/"}},
    {"codegen/text/", {"nlo/", "codegen/base/", "codegen/model/", "codegen/reference/", "codegen/text/"}},
    {"codegen/fold/",
     {"nlo/", "codegen/base/", "codegen/model/", "codegen/reference/", "codegen/structures/", "codegen/fold/"}},
    {"codegen/model_file/", {"nlo/", "codegen/base/", "codegen/model/", "codegen/structures/", "codegen/model_file/"}},
    {"trainer/", {"nlo/", "codegen/", "trainer/"}},
    // Config holds values and their places in the file; what they mean for a domain is checked in trainer/experiments.
    {"trainer/config/", {"nlo/", "codegen/", "trainer/base/", "trainer/config/"}},
    {"bindings/c/", {"nlo/", "codegen/", "bindings/"}},
    {"bench/", {"nlo/", "bench/"}},
    {"bench/rt_loop", {"nlo/", "bench/", "examples/control_loop/"}},
    {"bench/training_", {"nlo/", "bench/", "trainer/", "codegen/"}},
    {"tests/", {"nlo/", "codegen/", "trainer/", "bindings/", "bench/", "examples/", "tests/"}},
    {"examples/", {"nlo/"}},
};

/// A forbidden include: no file below `from` includes one below `target`, except files below `target` itself.
struct Wall {
  std::string_view from, target;
};

inline const std::vector<Wall> kWalls = {
    // Code that loads and checks experiments may include all folders whose keys it reads, but not the other way round.
    {"trainer/data/", "trainer/experiments/"},
    {"trainer/plants/", "trainer/experiments/"},
    {"trainer/structures/", "trainer/experiments/"},
    {"trainer/data/", "trainer/structures/"},
    {"trainer/plants/", "trainer/structures/"},
    // Losses and sensitivities use cotangents at samples, not the equations of a structure or a plant.
    {"trainer/learn/losses/", "trainer/structures/"},
    {"trainer/gradients/sensitivity/", "trainer/structures/"},
    {"trainer/learn/losses/", "trainer/plants/"},
    {"trainer/gradients/sensitivity/", "trainer/plants/"},
    {"trainer/learn/losses/", "trainer/gradients/sensitivity/"},
    {"trainer/gradients/sensitivity/", "trainer/learn/losses/"},
    // Structures are trained on data; they do not need f.
    {"trainer/structures/", "trainer/plants/"},
    {"trainer/gradients/nn/", "trainer/plants/"},
    {"trainer/learn/optim/", "trainer/plants/"},
    {"trainer/learn/training/", "trainer/plants/"},
    // nlo-prove and nlo-reproduce are separate programs: building nlo compiles neither proofs nor the reproduction.
    {"trainer/", "trainer/prove/"},
    {"trainer/", "trainer/reproduce/"},
    // A model, and what is computed from it, does not depend on the languages of exports.
    {"codegen/", "codegen/targets/"},
};

/// An include that may cross a wall or an arrow: the file (or its folder) and the target, as written. An unused
/// exception is an error, so that the list only shrinks.
struct Exception {
  std::string_view file, target;
};

inline const std::vector<Exception> kExceptions = {
    {"trainer/learn/losses/", "trainer/structures/observer_structure.h"},     // the interface of all structures
    {"trainer/structures/prior.cpp", "trainer/plants/equations_of_plant.h"},  // the structure whose prior is f
};

/// Standard headers that a freestanding C++20 compiler has and that use neither libm nor the heap.
inline const std::vector<std::string_view> kRuntimeStandardHeaders = {
    "array",  "bit",   "compare",     "concepts", "cstddef", "cstdint",     "initializer_list",
    "limits", "tuple", "type_traits", "utility",  "version", "immintrin.h", "arm_neon.h"};

}  // namespace nlo::properties
