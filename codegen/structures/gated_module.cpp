// SPDX-License-Identifier: MIT
#include "codegen/model/gated.h"

#include <fmt/format.h>

#include <cmath>

#include "codegen/model/field_checks.h"
#include "codegen/model/model_fields.h"
#include "codegen/structures/linear_latent_fields.h"
#include "codegen/structures/reference_units.h"

namespace nlo::codegen {
namespace {

template <class Scalar>
class GatedDynamics final : public ReferenceDynamics<Scalar> {
 public:
  using typename ReferenceDynamics<Scalar>::Vector;
  using typename ReferenceDynamics<Scalar>::Matrix;

  GatedDynamics(const Model& m, Activations activations)
      : sample_period_s_(m.sample_period_s),
        units_(own_part<Gated>(m).gates, own_part<Gated>(m).candidate, activations) {}

  void start(Matrix& z, const Matrix& y, const std::vector<bool>*) const override {
    z = units_.stepped(z, y, Scalar(1));
  }

  void advance(Vector& z, const Between<Scalar>& over, double dt_s) override {
    z = units_.stepped(z, over.y_next, static_cast<Scalar>(dt_s / sample_period_s_));
  }
  double longest_step_s() const override { return ReferenceUnits<Scalar>::kLongestGap * sample_period_s_; }

  Matrix slope(const Matrix& z, const Matrix& y, const Vector&) const override {
    return units_.slope(z, y) / static_cast<Scalar>(sample_period_s_);
  }

 private:
  double sample_period_s_;
  ReferenceUnits<Scalar> units_;
};

/// The dynamics of gated units in integers.
class IntegerGatedDynamics final : public ReferenceDynamics<float> {
 public:
  IntegerGatedDynamics(const Model& m, const QuantisedUnits& units)
      : sample_period_s_(m.sample_period_s), units_(units), in_float_(m, Activations::kRuntime) {}

  void start(Matrix& z, const Matrix& y, const std::vector<bool>*) const override {
    for (Eigen::Index b = 0; b < z.cols(); ++b) z.col(b) = stepped(units_, z.col(b), y.col(b), true, 1.0F);
  }
  void advance(Vector& z, const Between<float>& over, double dt_s) override {
    z = stepped(units_, z, over.y_next, dt_s == sample_period_s_, static_cast<float>(dt_s / sample_period_s_));
  }
  double longest_step_s() const override { return in_float_.longest_step_s(); }
  Matrix slope(const Matrix& z, const Matrix& y, const Vector& u) const override { return in_float_.slope(z, y, u); }

 private:
  double sample_period_s_;
  const QuantisedUnits& units_;
  GatedDynamics<float> in_float_;
};

class GatedHeader final : public CppStructureBase {
 public:
  using CppStructureBase::CppStructureBase;
  std::string title() const override { return "a learned state observer (gated: dz/dt = rate (target - z))"; }
  std::string description() const override {
    const Contraction& contraction = own_part<Gated>(m_).contraction;
    return fmt::format("// Latent state: {} gated units. Inverse map T*: {}.\n", nz_, inverse_map().description()) +
           (contraction.none()
                ? ""
                : fmt::format("// Contracting: the effect of the start of z falls as exp(-{:.3g} t) or faster, "
                              "proven from the weights.\n",
                              contraction.rate)) +
           input_comment();
  }
  std::string header() const override { return "gated_observer.h"; }
  std::vector<CppNetwork> networks() const override { return {gates(), candidate(), inverse_map()}; }
  std::string model_type() const override {
    return fmt::format("GatedModel<{}, {}, {}, {}, {}, {}, {}{}>;  // n_x, n_y, n_z, gates, candidate, T*{}\n",
                       init_.scalar_name(), nx_, ny_, nz_, gates().map_type(init_), candidate().map_type(init_),
                       inverse_map().map_type(init_), input_arguments(), input_words());
  }
  std::string observer() const override { return "GatedObserver"; }
  std::string leading_fields() const override {
    return fmt::format("    .initial = {},\n", init_.vector(m_.initial_latent, "initial_latent"));
  }

  Eigen::Index step_multiply_adds() const override { return gates().multiply_adds() + candidate().multiply_adds(); }
  Eigen::Index step_activations() const override { return 3 * nz_; }
  Eigen::Index own_scalars() const override { return nz_ + 1; }  // stale_after

 private:
  CppNetwork gates() const {
    return unit(network("gates", "GatesLayer", "GatesNetwork", reads(false)), &QuantisedUnits::gates);
  }
  CppNetwork candidate() const {
    return unit(network("candidate", "CandidateLayer", "CandidateNetwork", "[g z" + reads(false).substr(2)),
                &QuantisedUnits::candidate);
  }
  CppNetwork unit(CppNetwork network, const QuantisedNetwork QuantisedUnits::*part) const {
    if (quantised_ != nullptr) network.quantised = &((*quantised_->units).*part);
    return network;
  }
};

/// Returns the largest magnitude of [z; y]; z stays within +-1.
Eigen::VectorXd largest_reads(const Model& m) {
  Eigen::VectorXd largest(m.nz() + m.nr());
  largest << Eigen::VectorXd::Ones(m.nz()), largest_readings(m);
  return largest;
}

/// Throws Error unless the weights prove the contraction that the model file states.
void check_contraction(const Gated& own, const Model& m) {
  if (own.contraction.none()) return;
  check_shape(own.contraction.metric, m.nz(), "contraction.metric", "n_z");
  check_positive(own.contraction.metric, "contraction.metric");
  constexpr double kRounding = 1.0 + 1e-9;
  const double proven = proven_rate(m, own, own.contraction.metric);
  if (!(own.contraction.rate > 0.0) || own.contraction.rate > kRounding * proven)
    fail("contraction.rate is {}, but gates and candidate only prove {} in that metric; remove the contraction",
         own.contraction.rate, proven > 0.0 ? std::to_string(proven) : "none");
}

class GatedModule final : public StructureModule {
 public:
  std::string_view name() const override { return "gated"; }

  std::vector<const char*> keys() const override { return {"gates", "candidate", "inverse_map", "contraction"}; }
  void read(const Field& file, Model& m) const override {
    Gated own{network(file["gates"]), network(file["candidate"]), network(file["inverse_map"])};
    if (file.has("contraction")) {
      const Field contraction = file["contraction"];
      contraction.allow_only({"metric", "rate"});
      own.contraction = {vector(contraction["metric"]), number(contraction["rate"])};
    }
    m.structure = std::move(own);
  }
  void write(const Model& m, JsonObject& file) const override {
    const Gated& own = own_part<Gated>(m);
    file.network("gates", own.gates);
    file.network("candidate", own.candidate);
    file.network("inverse_map", own.inverse_map);
    if (own.contraction.none()) return;
    JsonObject contraction(file.inner());
    contraction.vector("metric", own.contraction.metric);
    contraction.field("rate", literal(own.contraction.rate));
    file.field("contraction", contraction.text());
  }
  void check(const Model& m) const override {
    check_no_angles(m);
    const Gated& own = own_part<Gated>(m);
    const Eigen::VectorXd largest = largest_reads(m);
    check_gate_layer(own.gates, largest, 2 * m.nz(), "gates", "n_u x (n_z + n_r)");
    check_gate_layer(own.candidate, largest, m.nz(), "candidate", "n_u x (n_z + n_r)");
    for (Eigen::Index r = 0; r < m.nz(); ++r)
      if (!(std::abs(m.initial_latent(r)) <= 1.0))
        fail("initial_latent[{}] is {}; a gated unit is between -1 and 1", r, m.initial_latent(r));
    check_network(own.inverse_map, m.nz() + m.nr(), m.nx(), "inverse_map", "n_u x (n_z + n_r)");
    check_sums(own.inverse_map, largest, "inverse_map");
    check_contraction(own, m);
  }

  std::vector<Named<Network>> networks(Model& m) const override {
    Gated& own = own_part<Gated>(m);
    const Eigen::Index all = m.nz() + m.nr();
    return {{"gates", &own.gates, all},
            {"candidate", &own.candidate, all},
            {"inverse_map", &own.inverse_map, reads_of(own.inverse_map, m)}};
  }
  Network* inverse_map(Model& m) const override { return &own_part<Gated>(m).inverse_map; }
  bool computes_outputs() const override { return true; }
  Eigen::Index gated_units(const Model& m) const override { return m.nz(); }
  bool reads_stalenesses() const override { return true; }
  std::optional<Eigen::VectorXd> latent_limit(const Model& m) const override { return Eigen::VectorXd::Ones(m.nz()); }
  std::optional<Contraction> contraction(const Model& m) const override {
    return find_contraction(m, own_part<Gated>(m));
  }

  std::unique_ptr<ReferenceDynamics<float>> dynamics_in_float(const Model& m, Activations a) const override {
    return std::make_unique<GatedDynamics<float>>(m, a);
  }
  std::unique_ptr<ReferenceDynamics<double>> dynamics_in_double(const Model& m, Activations a) const override {
    return std::make_unique<GatedDynamics<double>>(m, a);
  }

  std::unique_ptr<ReferenceDynamics<float>> dynamics_in_integers(const Model& m,
                                                                 const QuantisedUnits& units) const override {
    return std::make_unique<IntegerGatedDynamics>(m, units);
  }

  std::unique_ptr<CppStructure> cpp(const ExportSource& source) const override {
    return std::make_unique<GatedHeader>(source);
  }
  Abilities abilities() const override { return {.c99 = true, .int16 = true}; }
  std::map<std::string, std::string> c99(const ExportSource& source) const override {
    const QuantisedModel* integers = source.quantised;
    const auto shift = [&](const QuantisedNetwork QuantisedUnits::*part) {
      return integers == nullptr ? "" : std::to_string(((*integers->units).*part).layers.front().shift);
    };
    return {{"LATENT", integers == nullptr ? "c99/gated.c.in" : "c99/gated_int16.c.in"},
            {"GATE_SHIFT", shift(&QuantisedUnits::gates)},
            {"CANDIDATE_SHIFT", shift(&QuantisedUnits::candidate)},
            {"DECAYS", "true"},
            {"TANH", "true"},
            {"FIRST", "    advance(REGULAR_STEP, o->z, o->y, o->y);\n"},
            {"STEP_DT_COST", "Some 200 operations a unit more than a sample period"}};
  }
};

}  // namespace

void check_gate_layer(const Network& n, const Eigen::VectorXd& largest, int outputs, const char* field,
                      const char* meaning) {
  check_network(n, static_cast<int>(largest.size()), outputs, field, meaning);
  if (n.layers.size() != 1 || n.skip.size() != 0)
    fail("{} has {} layers{}; it must have exactly one layer and no linear path", field, n.layers.size(),
         n.skip.size() != 0 ? " and a linear path" : "");
  check_sums(n, largest, field);
}

const StructureModule& gated_module() {
  static const GatedModule module;
  return module;
}

}  // namespace nlo::codegen
