// SPDX-License-Identifier: MIT
// Proven bounds of a model: each row has a bound and the largest value that a search has found.
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

/// The kind of evidence for a number.
enum class Evidence {
  kProven,  ///< by a theorem or an exact computation: nothing can exceed it
  kSampled  ///< the largest at finitely many points; other points may exceed it
};
const char* evidence_name(Evidence evidence);

/// If `bound` is proven, the quantity never exceeds it. `found` is the largest value that a search has found. If a
/// model does not have this quantity, `bound` and `found` are NaN, and the note gives the reason.
struct CertificateRow {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  std::string id;    ///< "lipschitz", "latent.z3": used in files and tests
  std::string what;  ///< the bounded quantity, in words
  std::string unit = {};
  Evidence evidence = Evidence::kProven;
  double bound = kNone;
  double found = kNone;
  std::string where = {};  ///< where the search found it, in words
  std::string note = {};

  /// Returns true if the search found a value above a proven bound, by more than its own rounding. That is a defect of
  /// this program.
  bool is_broken() const {
    return evidence == Evidence::kProven && found > bound + kFalsifierRounding * std::abs(bound);
  }
  static constexpr double kFalsifierRounding = 1e-9;
};

struct CertifyOptions {
  std::int64_t boxes = 0;  ///< limit for each branch and bound; 0: about a minute of one core
  double gap = 0.2;        ///< a branch and bound ends where bound / found - 1 is below this
  std::uint64_t seed = 1;  ///< seed of the searches
  // For the steady error:
  const Experiment* experiment = nullptr;  ///< the model's experiment; null: unknown
  double noise = 0.0;                      ///< V: the largest error of a sample of an output
  double disturbance = 0.0;                ///< W: the largest error of a state's derivative [state / s]
  StateBox box = {};                       ///< region of the state; empty: the region of simulated runs
  /// Called with a title at the start of each group of rows; an empty function is not called.
  std::function<void(const std::string&)> progress = {};
};

struct Certificate {
  std::string model, structure;
  std::vector<CertificateRow> rows;
  std::vector<std::string> assumptions;  ///< assumptions of all proofs
};

/// Returns all rows.
Certificate certify(const codegen::Model& model, const CertifyOptions& options);

/// Returns the rows of one kind. A table in certificate.cpp lists these functions.
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

/// Returns a row without a bound.
CertificateRow absent_row(std::string id, std::string what, std::string why);

/// Returns a table, then notes and assumptions.
std::string certificate_text(const Certificate& certificate);
std::string certificate_json(const Certificate& certificate);

/// Returns a sentence that names the rows whose search found a value above the bound; empty: none.
std::string broken_rows(const Certificate& certificate);

}  // namespace nlo::trainer
