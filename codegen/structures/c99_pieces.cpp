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

void add_rk4(Quantities& to) {
  to.integer("structure", "", "kLongestGap", kMostPieces);
  add_pieces(to);
  add_rk4_weights(to);
  add_part(to, "advance", "part", "((Scalar)i+kParts[s])*step->share", to.source().model.hold);
}

void add_part(Quantities& to, const std::string& function, const std::string& name, const std::string& part,
              Hold hold) {
  const std::string held = to.source().init(0.0, "part");
  to.code("hold", function, name + "=" + (hold == Hold::kZeroOrder ? held : part), true);
  to.code("hold", function, name + "=" + (hold == Hold::kZeroOrder ? part : held), false);
}

void add_pieces(Quantities& to) {
  to.scalar("sample_period_s", "", "kStep.h", to.source().model.sample_period_s);
  to.scalar("share of a piece", "", "kStep.share", 1.0);
  to.integer("pieces of a step", "", "kStep.pieces", 1.0);
}

void add_rk4_weights(Quantities& to) {
  to.vector("parts of RK4", "", "advance.kParts", Eigen::Vector4d(0.0, 0.5, 0.5, 1.0));
  to.vector("weights of RK4", "", "advance.kWeights", Eigen::Vector4d(1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6));
}

}  // namespace nlo::codegen
