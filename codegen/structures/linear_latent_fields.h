// SPDX-License-Identifier: MIT
// Several structures have the linear latent system z' = D z + F y. This file reads and writes D and F in the model
// file, checks them, and writes their part of a C++ header.
#pragma once

#include <string>

#include "codegen/structures/structure_module.h"
#include "codegen/text/cpp_structure.h"

namespace nlo::codegen {

void read_linear_latent(const Field& file, LinearLatent& latent);
void write_linear_latent(const LinearLatent& latent, JsonObject& file);

/// Checks the shapes of D and F, that D is Hurwitz, and that |A| < 1 at the sample period, also in float.
void check_linear_latent(const Model& model);

/// Returns the largest |z| to which readings within their ranges can lead, n_z. It is the start plus, for each mode,
/// the sum of all past readings: |F| max|y| / |Re lambda| in continuous time, (|B0| + |B1|) max|y| / (1 - |A|) in
/// steps. Throws Error if float cannot represent it.
Eigen::VectorXd largest_latent(const Model& model);

/// Checks that the map reads [z; y], that it does not change when an angle output turns once and z turns with it by S
/// wrap, and that its sums stay in float for every z to which readings can lead.
void check_latent_map(const Model& model);

/// Returns the rates of the fastest and the slowest mode that reads an output [1/s].
double fastest_driven_mode(const LinearLatent& latent);
std::optional<double> slowest_driven_mode(const LinearLatent& latent);

/// Returns the number of entries of [z; y] that the inverse map reads: those of z if y has no weight.
Eigen::Index reads_of(const Network& inverse_map, const Model& model);

/// Returns the values of a KKL observer (16) for templates/c99. Other structures of the family extend them.
std::map<std::string, std::string> c99_of_linear_latent(const ExportSource& source);

/// The header of a KKL observer (16). Other observers of the family extend it.
class KklHeader : public CppStructureBase {
 public:
  explicit KklHeader(const ExportSource& source);

  std::string title() const override { return "a learned state observer (Kazantzis-Kravaris/Luenberger)"; }
  std::string description() const override;
  std::string header() const override { return "kkl_observer.h"; }
  std::vector<CppNetwork> networks() const override { return {inverse_map()}; }
  std::string model_type() const override;
  std::string observer() const override { return "KklObserver"; }
  std::string leading_fields() const override { return latent_fields(); }

  Eigen::Index step_multiply_adds() const override { return linear_multiply_adds(); }
  Eigen::Index step_activations() const override { return 0; }
  Eigen::Index estimate_multiply_adds() const override;
  Eigen::Index own_scalars() const override;
  std::string trailing_fields() const override;

 protected:
  bool may_saturate() const override { return true; }
  Eigen::Index linear_multiply_adds() const { return nz_ + 2 * latent_.pairs + 2 * nz_ * nr_; }
  std::string latent_fields() const;
  std::string step(const StepMatrices& step, std::size_t indent) const;

  const LinearLatent& latent_;
};

}  // namespace nlo::codegen
