// SPDX-License-Identifier: MIT
#include "codegen/structures/c99_pieces.h"

#include <nlo/explicit_rk.h>

namespace nlo::codegen {

std::string c99_part(Hold hold, const std::string& part, const Initialiser& init) {
  return hold == Hold::kZeroOrder ? init(0.0, "part") : part;
}

std::map<std::string, std::string> c99_of_rk4(const ExportSource& source, const char* slope) {
  const Initialiser& init = source.init;
  return {{"LATENT", "c99/rk4.c.in"},
          {"SLOPE", slope},
          {"PHI", ""},
          {"DIVERGES", "true"},
          {"LAST_STATUS", "DIVERGED"},
          {"LONGEST_GAP", std::to_string(kMostPieces)},
          {"FIRST", ""},
          {"STEP_DT_COST", "For each sample period as much"},
          {"PART", c99_part(source.model.hold, "((Scalar)i + kParts[s]) * step->share", init)},
          {"SIXTH", init(1.0 / 6, "a sixth")},
          {"THIRD", init(1.0 / 3, "a third")}};
}

}  // namespace nlo::codegen
