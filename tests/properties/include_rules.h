// SPDX-License-Identifier: MIT
// Which way includes may point: arrows between the parts, walls within them, exceptions. include_arrows_test.cpp holds
// every file to them.
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
    // Rooms of the generator, as their READMEs say.
    {"codegen/base/", {"codegen/base/"}},
    {"codegen/model/", {"nlo/", "codegen/base/", "codegen/model/"}},
    {"codegen/reference/", {"nlo/", "codegen/base/", "codegen/model/", "codegen/reference/"}},
    {"codegen/text/", {"nlo/", "codegen/base/", "codegen/model/", "codegen/reference/", "codegen/text/"}},
    {"codegen/fold/",
     {"nlo/", "codegen/base/", "codegen/model/", "codegen/reference/", "codegen/structures/", "codegen/fold/"}},
    {"codegen/model_file/", {"nlo/", "codegen/base/", "codegen/model/", "codegen/structures/", "codegen/model_file/"}},
    {"trainer/", {"nlo/", "codegen/", "trainer/"}},
    // An experiment file is values and their places: what they mean to a domain is checked above.
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
    // Code that loads and checks experiments may include all rooms that keys belong to, but not the other way round.
    {"trainer/data/", "trainer/experiments/"},
    {"trainer/plants/", "trainer/experiments/"},
    {"trainer/structures/", "trainer/experiments/"},
    {"trainer/data/", "trainer/structures/"},
    {"trainer/plants/", "trainer/structures/"},
    // A loss term and a sensitivity speak in cotangents at samples: no structure's equations, no plant's.
    {"trainer/learn/losses/", "trainer/structures/"},
    {"trainer/gradients/sensitivity/", "trainer/structures/"},
    {"trainer/learn/losses/", "trainer/plants/"},
    {"trainer/gradients/sensitivity/", "trainer/plants/"},
    {"trainer/learn/losses/", "trainer/gradients/sensitivity/"},
    {"trainer/gradients/sensitivity/", "trainer/learn/losses/"},
    // The method needs data, not f.
    {"trainer/structures/", "trainer/plants/"},
    {"trainer/gradients/nn/", "trainer/plants/"},
    {"trainer/learn/optim/", "trainer/plants/"},
    {"trainer/learn/training/", "trainer/plants/"},
    // nlo-prove and nlo-reproduce are programs of their own: whoever builds nlo compiles neither proofs nor the paper.
    {"trainer/", "trainer/prove/"},
    {"trainer/", "trainer/reproduce/"},
    // A model and what is made of it do not know the languages it is written in.
    {"codegen/", "codegen/targets/"},
};

/// An include that may cross a wall or an arrow: the file (or its folder) and the target, as written. One that no file
/// needs any more is an error, so that the list only shrinks.
struct Exception {
  std::string_view file, target;
};

inline const std::vector<Exception> kExceptions = {
    {"trainer/learn/losses/", "trainer/structures/observer_structure.h"},     // the interface of all structures
    {"trainer/structures/prior.cpp", "trainer/plants/equations_of_plant.h"},  // the one whose prior is f
};

/// Standard headers that a freestanding or bare-metal C++20 compiler has, and that pull in neither libm nor the heap.
inline const std::vector<std::string_view> kRuntimeStandardHeaders = {
    "array",  "bit",   "compare",     "concepts", "cstddef", "cstdint",     "initializer_list",
    "limits", "tuple", "type_traits", "utility",  "version", "immintrin.h", "arm_neon.h"};

}  // namespace nlo::properties
