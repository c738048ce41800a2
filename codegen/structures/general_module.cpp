// SPDX-License-Identifier: MIT
#include "codegen/model/general.h"

#include <fmt/format.h>
#include <nlo/explicit_rk.h>

#include "codegen/model/field_checks.h"
#include "codegen/model/hold.h"
#include "codegen/model/model_fields.h"
#include "codegen/reference/integrate.h"
#include "codegen/structures/c99_pieces.h"
#include "codegen/structures/structure_module.h"

namespace nlo::codegen {
namespace {

template <class Scalar>
class GeneralDynamics final : public ReferenceDynamics<Scalar> {
 public:
  using typename ReferenceDynamics<Scalar>::Vector;
  using typename ReferenceDynamics<Scalar>::Matrix;

  GeneralDynamics(const Model& m, Activations activations)
      : hold_(m.hold), sample_period_s_(m.sample_period_s), dynamics_(own_part<General>(m).dynamics, activations) {}

  void advance(Vector& z, const Between<Scalar>& over, double dt_s) override {
    integrate(*this, hold_, sample_period_s_, z, over, dt_s);
  }
  double longest_step_s() const override { return kMostPieces * sample_period_s_; }
  Matrix slope(const Matrix& z, const Matrix& y, const Vector&) const override {
    return dynamics_(stacked<Scalar>(z, y));
  }

 private:
  Hold hold_;
  double sample_period_s_;
  ReferenceNetwork<Scalar> dynamics_;
};

class GeneralHeader final : public CppStructureBase {
 public:
  using CppStructureBase::CppStructureBase;
  std::string title() const override { return "a learned state observer (general: dz/dt = F(z, y))"; }
  std::string description() const override {
    return fmt::format("// Latent state: {}, RK4, {} hold. F: {}. G: {}.\n", nz_, hold_name(m_.hold),
                       dynamics().description(), inverse_map().description()) +
           input_comment();
  }
  std::string header() const override { return "general_observer.h"; }
  std::vector<CppNetwork> networks() const override { return {dynamics(), inverse_map()}; }
  std::string model_type() const override {
    return fmt::format("GeneralModel<{}, {}, {}, {}, {}, {}{}>;  // n_x, n_y, n_z{}\n", init_.scalar_name(), nx_, ny_,
                       nz_, dynamics().map_type(init_), inverse_map().map_type(init_), input_arguments(),
                       read_inputs_ > 0 ? ", F, G, n_u" : "");
  }
  std::string observer() const override { return "GeneralObserver"; }
  std::string leading_fields() const override {
    return fmt::format("    .hold = {},\n    .initial = {},\n", hold_identifier(m_.hold),
                       init_.vector(m_.initial_latent, "initial_latent"));
  }

  Eigen::Index step_multiply_adds() const override { return 4 * dynamics().multiply_adds(); }
  Eigen::Index step_activations() const override { return 4 * dynamics().activations(); }
  Eigen::Index own_scalars() const override { return nz_ + 1; }  // stale_after and hold share one

 private:
  CppNetwork dynamics() const { return network("dynamics", "DynamicsLayer", "DynamicsNetwork", reads(false)); }
};

class GeneralModule final : public StructureModule {
 public:
  std::string_view name() const override { return "general"; }

  std::vector<const char*> keys() const override { return {"dynamics", "inverse_map"}; }
  void read(const Field& file, Model& m) const override {
    m.structure = General{network(file["dynamics"]), network(file["inverse_map"])};
  }
  void write(const Model& m, JsonObject& file) const override {
    const General& own = own_part<General>(m);
    file.network("dynamics", own.dynamics);
    file.network("inverse_map", own.inverse_map);
  }
  void check(const Model& m) const override {
    check_no_angles(m);
    const General& own = own_part<General>(m);
    check_network(own.dynamics, m.nz() + m.nr(), m.nz(), "dynamics",
                  !m.inputs.empty() ? "n_u x (n_z + n_y + inputs)" : "n_u x (n_z + n_y)");
    check_network(own.inverse_map, m.nz(), m.nx(), "inverse_map", "n_u x n_z");
  }

  std::vector<Named<Network>> networks(Model& m) const override {
    General& own = own_part<General>(m);
    return {{"dynamics", &own.dynamics, m.nz() + m.nr()}, {"inverse_map", &own.inverse_map, m.nz()}};
  }
  Network* inverse_map(Model& m) const override { return &own_part<General>(m).inverse_map; }

  std::unique_ptr<ReferenceDynamics<float>> dynamics_in_float(const Model& m, Activations a) const override {
    return std::make_unique<GeneralDynamics<float>>(m, a);
  }
  std::unique_ptr<ReferenceDynamics<double>> dynamics_in_double(const Model& m, Activations a) const override {
    return std::make_unique<GeneralDynamics<double>>(m, a);
  }

  bool may_diverge() const override { return true; }
  std::unique_ptr<CppStructure> cpp(const ExportSource& source) const override {
    return std::make_unique<GeneralHeader>(source);
  }
  Abilities abilities() const override { return {.c99 = true, .int16 = true}; }
  std::map<std::string, std::string> c99(const ExportSource& source) const override {
    return c99_of_rk4(source, "c99/general.c.in");
  }
};

}  // namespace

const StructureModule& general_module() {
  static const GeneralModule module;
  return module;
}

}  // namespace nlo::codegen
