// SPDX-License-Identifier: MIT
// The linear latent system z' = D z + F y, which several structures have: its fields in the model file, its checks, its
// part of a C++ header.
#pragma once

#include <string>

#include "codegen/structures/structure_module.h"
#include "codegen/text/cpp_structure.h"

namespace nlo::codegen {

void read_linear_latent(const Field& file, LinearLatent& latent);
void write_linear_latent(const LinearLatent& latent, JsonObject& file);

/// D and F: shapes, D Hurwitz, and |A| < 1 at the sample period, in float too.
void check_linear_latent(const Model& model);

/// The largest |z| that readings within their ranges lead to, n_z: its start, and of each mode all that its past puts
/// into it, |F| max|y| / |Re lambda| in continuous time, (|B0| + |B1|) max|y| / (1 - |A|) in steps. Throws Error where
/// float cannot hold it.
Eigen::VectorXd largest_latent(const Model& model);

/// T* reads [z; y]; when an angle output turns once, z turns with it by S wrap, and T* must not see that. Its
/// sums stay in float wherever readings lead z.
void check_latent_map(const Model& model);

/// Rates of the fastest and the slowest mode that reads an output [1/s].
double fastest_driven_mode(const LinearLatent& latent);
std::optional<double> slowest_driven_mode(const LinearLatent& latent);

/// How many of [z; y] the inverse map reads: z alone where y has no weight.
Eigen::Index reads_of(const Network& inverse_map, const Model& model);

/// The part of a KKL observer (16) in templates/c99, which others of the family extend.
std::map<std::string, std::string> c99_of_linear_latent(const ExportSource& source);

/// The header of a KKL observer (16), which other observers of the family extend.
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
