// SPDX-License-Identifier: MIT
// Proven bounds of a model: a row for each bound, with the largest value that a falsifier has found.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/prove/plant_enclosure.h"

namespace nlo::trainer {

/// How far a number can be trusted.
enum class Evidence {
  kProven,  ///< a theorem or an exact computation: nothing can exceed it
  kSampled  ///< the largest found at finitely many points: there may be larger ones between them
};
const char* evidence_name(Evidence evidence);

/// Nothing in its unit is above `bound` if that is proven. `found` is the largest that a search has met. A row that a
/// model does not have is there all the same, with neither, and its note says why.
struct CertificateRow {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  std::string id;    ///< "lipschitz", "latent.z3": of a file and a test
  std::string what;  ///< the bounded quantity, for people
  std::string unit = {};
  Evidence evidence = Evidence::kProven;
  double bound = kNone;
  double found = kNone;
  std::string where = {};  ///< found, for people
  std::string note = {};

  /// Its falsifier is above a proven bound, by more than the falsifier's own rounding: a defect of this program.
  bool is_broken() const {
    return evidence == Evidence::kProven && found > bound + kFalsifierRounding * std::abs(bound);
  }
  static constexpr double kFalsifierRounding = 1e-9;
};

struct CertifyOptions {
  std::int64_t boxes = 0;  ///< at most, of each branch and bound; 0: some minute of one core each
  double gap = 0.2;        ///< a branch and bound ends where bound / found - 1 is below this
  std::uint64_t seed = 1;  ///< seed of falsifiers
  // For the steady error:
  const Experiment* experiment = nullptr;  ///< the model's experiment; null: not known
  double noise = 0.0;                      ///< V: each sample of each output is off by at most this
  double disturbance = 0.0;                ///< W: each state's derivative is off by at most this [state / s]
  StateBox box = {};                       ///< region of the state; empty: the region of simulated runs
  /// Said of each group of rows as it begins; may be empty.
  std::function<void(const std::string&)> progress = {};
};

struct Certificate {
  std::string model, structure;
  std::vector<CertificateRow> rows;
  std::vector<std::string> assumptions;  ///< assumptions of all proofs
};

/// All rows.
Certificate certify(const codegen::Model& model, const CertifyOptions& options);

/// Rows of one kind. Makers stand in a table of certificate.cpp.
using CertificateRows = std::vector<CertificateRow>;
CertificateRows latent_rows(const codegen::Model& model, const CertifyOptions& options);
CertificateRows contraction_rows(const codegen::Model& model, const CertifyOptions& options);
CertificateRows lipschitz_rows(const codegen::Model& model, const CertifyOptions& options);
CertificateRows estimate_rows(const codegen::Model& model, const CertifyOptions& options);
CertificateRows arithmetic_rows(const codegen::Model& model, const CertifyOptions& options);
CertificateRows steady_rows(const codegen::Model& model, const CertifyOptions& options);
CertificateRows robustness_rows(const codegen::Model& model, const CertifyOptions& options);

/// Returns the reason why there are no rows about T*; empty if there are. Features of T* must be linear in z and y.
std::string reason_against_map(const codegen::Model& model);

/// Returns the reason why there are no rows about the plant that the model was trained on; empty if there are. KKL
/// observers of the plant's own states, without inputs, have such rows.
std::string reason_against_plant(const codegen::Model& model, const CertifyOptions& options);

/// A row without a bound.
CertificateRow absent_row(std::string id, std::string what, std::string why);

/// A table, then notes and assumptions.
std::string certificate_text(const Certificate& certificate);
std::string certificate_json(const Certificate& certificate);

/// The rows whose falsifier is above them, in one sentence; empty: none.
std::string broken_rows(const Certificate& certificate);

}  // namespace nlo::trainer
