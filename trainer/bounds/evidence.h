// SPDX-License-Identifier: MIT
// How far a number can be trusted.
#pragma once

namespace nlo::trainer {

enum class Evidence {
  kProven,   ///< a theorem or an exact computation: nothing can exceed it
  kSampled,  ///< the largest found at finitely many points: there may be larger ones between them
  kAssumed   ///< given by the user
};
const char* evidence_name(Evidence evidence);

}  // namespace nlo::trainer
