// SPDX-License-Identifier: MIT
#include "codegen/model/carried.h"

#include <fmt/format.h>
#include <nlo/carried_observer.h>

#include "codegen/base/embedded_text.h"
#include "codegen/model/field_checks.h"
#include "codegen/model/hold.h"
#include "codegen/model/latent_step.h"
#include "codegen/model/model_fields.h"
#include "codegen/structures/carried_dynamics.h"
#include "codegen/structures/linear_latent_fields.h"

namespace nlo::codegen {
namespace {

/// Returns c: a row for each vector of the states, a column for each mode of each vector of the outputs. If T* reads y,
/// a column for each vector of the outputs follows.
Eigen::MatrixXd vector_weights(const Model& m, const FoldedNetwork& map) {
  const Eigen::Index modes = m.nz() / m.ny(), vectors = m.ny() / kAxes, carried = vectors * modes;
  const bool reads_output = map.inputs() > m.nz();
  Eigen::MatrixXd weights(m.nx() / kAxes, carried + (reads_output ? vectors : 0));
  for (Eigen::Index s = 0; s < weights.rows(); ++s)
    for (Eigen::Index f = 0; f < weights.cols(); ++f)
      weights(s, f) = map.layers.front().weights(
          kAxes * s, f < carried ? f / modes * kAxes * modes + f % modes : m.nz() + kAxes * (f - carried));
  return weights;
}

/// Returns the matrix of the map that has these weights: [z; y; w] to x_hat, or z to x_hat.
Eigen::MatrixXd spread(const Model& m, const Eigen::MatrixXd& weights, Eigen::Index inputs) {
  const Eigen::Index modes = m.nz() / m.ny(), carried = m.ny() / kAxes * modes;
  Eigen::MatrixXd map = Eigen::MatrixXd::Zero(m.nx(), inputs);
  for (Eigen::Index i = 0; i < m.nx(); ++i)
    for (Eigen::Index f = 0; f < weights.cols(); ++f) {
      const Eigen::Index c = i % kAxes;
      map(i, f < carried ? (f / modes * kAxes + c) * modes + f % modes : m.nz() + kAxes * (f - carried) + c) =
          weights(i / kAxes, f);
    }
  return map;
}

/// Writes the latent system of one component as in the header of a KKL observer.
class ComponentHeader final : public KklHeader {
 public:
  using KklHeader::KklHeader;
  std::string fields() const { return latent_fields(); }
};

class CarriedHeader final : public CppStructureBase {
 public:
  explicit CarriedHeader(const ExportSource& source)
      : CppStructureBase(source),
        own_(own_part<Carried>(source.model)),
        weights_(vector_weights(source.model, source.folded.network("inverse_map"))),
        component_(component_of(source.model)),
        folded_(folded_latent(component_)),
        latent_({component_, folded_, source.init}) {}

  std::string title() const override { return "a learned state observer (vectors that a known rotation carries)"; }
  std::string description() const override {
    return fmt::format(
        "// Latent state: {} vectors, z' = D z + F y - w x z, {} hold; w = [{}] in rad/s.\n"
        "// Estimate: a weighted sum of these vectors{}{}. It turns with the sensor's axes.\n",
        modes() * ny_ / kAxes, hold_name(m_.hold), names(m_.inputs), reads_output() ? " and of y" : "",
        own_.unit_length ? ", scaled to length 1" : "");
  }
  std::string header() const override { return "carried_observer.h"; }
  std::vector<CppNetwork> networks() const override { return {}; }
  std::string model_type() const override {
    return fmt::format("CarriedModel<{}, {}, {}, {}, {}, {}, {}{}>;  // n_x, n_y, modes, pairs, reads y, unit length\n",
                       init_.scalar_name(), nx_, ny_, modes(), own_.component.pairs, reads_output(), own_.unit_length,
                       m_.input_hold == Hold::kZeroOrder ? "" : ", " + hold_identifier(m_.input_hold));
  }
  std::string observer() const override { return "CarriedObserver"; }
  std::string leading_fields() const override { return latent_.fields(); }
  std::string trailing_fields() const override {
    return fmt::format("    .weights = {},\n", init_.matrix(weights_, "inverse_map"));
  }

  Eigen::Index step_multiply_adds() const override {
    constexpr Eigen::Index kRotation = 80;
    return kRotation + ny_ / kAxes * (modes() + 1) * kAxes * kAxes + ny_ * (3 * modes() + 2 * own_.component.pairs);
  }
  Eigen::Index step_activations() const override { return 0; }
  Eigen::Index estimate_multiply_adds() const override {
    constexpr Eigen::Index kUnit = 30;
    return kAxes * weights_.size() + (own_.unit_length ? kUnit * weights_.rows() : 0);
  }
  Eigen::Index estimate_activations() const override { return 0; }
  Eigen::Index own_scalars() const override { return latent_.own_scalars() + weights_.size(); }

 private:
  Eigen::Index modes() const { return nz_ / ny_; }
  bool reads_output() const { return weights_.cols() > ny_ / kAxes * modes(); }
  /// Folds the latent system of one component. The map is not used.
  static FoldedModel folded_latent(const Model& component) {
    FoldedModel folded;
    folded.step = latent_step(component, component.sample_period_s);
    folded.steady_gain = steady_gain(component);
    return folded;
  }
  static std::string names(const std::vector<Channel>& channels) {
    std::string text;
    for (const Channel& channel : channels) text += (text.empty() ? "" : ", ") + channel.name;
    return text;
  }

  const Carried& own_;
  const Eigen::MatrixXd weights_;
  const Model component_;
  const FoldedModel folded_;
  const ComponentHeader latent_;
};

void check_vectors(const Model& m) {
  if (m.ny() % kAxes != 0) fail("there are {} outputs; a carried observer needs vectors of three components", m.ny());
  if (m.nx() % kAxes != 0) fail("there are {} states; a carried observer needs vectors of three components", m.nx());
  if (m.inputs.size() != kAxes)
    fail("there are {} inputs; a carried observer needs exactly three: the components of the rate of rotation in rad/s",
         m.inputs.size());
  const double turn = largest_readings(m).tail<kAxes>().norm() * m.sample_period_s;
  if (!(turn <= CarriedLimits::kMostTurn))
    fail(
        "input_max lets the rate turn by {} rad in a sample period; beyond {} a sampled rate does not determine the "
        "rotation",
        turn, CarriedLimits::kMostTurn);
}

/// Checks that T* is the same weighted sum for each component.
void check_map(const Model& m) {
  const Network& map = own_part<Carried>(m).inverse_map;
  check_network(map, m.nz() + m.nr(), m.nx(), "inverse_map", "n_u x (n_z + n_y + inputs)");
  if (map.layers.size() != 1)
    fail("inverse_map has {} layers; a carried observer needs one, the sum of vectors", map.layers.size());
  const FoldedNetwork folded = fold(map, map.features.cols());
  const Eigen::MatrixXd& weights = folded.layers.front().weights;
  const Eigen::MatrixXd sums = spread(m, vector_weights(m, folded), weights.cols());
  const double largest = weights.cwiseAbs().maxCoeff();
  constexpr double kRounding = 1e-6;  // training computes in float
  if (!((weights - sums).cwiseAbs().maxCoeff() <= kRounding * largest) ||
      !(folded.layers.front().bias.cwiseAbs().maxCoeff() <= kRounding * largest))
    fail("inverse_map is not one sum of vectors: each component must have the same weights, and no bias");
}

class CarriedModule final : public StructureModule {
 public:
  std::string_view name() const override { return "carried"; }

  std::vector<const char*> keys() const override {
    return {"starts_steady", "pairs", "eigenvalues", "output_injection", "inverse_map", "unit_length"};
  }
  void read(const Field& file, Model& m) const override {
    Carried& own = m.structure.emplace<Carried>();
    read_linear_latent(file, own.component);
    own.inverse_map = network(file["inverse_map"]);
    own.unit_length = boolean(file["unit_length"]);
  }
  void write(const Model& m, JsonObject& file) const override {
    const Carried& own = own_part<Carried>(m);
    write_linear_latent(own.component, file);
    file.network("inverse_map", own.inverse_map);
    file.field("unit_length", own.unit_length ? "true" : "false");
  }
  void check(const Model& m) const override {
    check_no_angles(m);
    check_vectors(m);
    const Model one = component_of(m);
    if (m.nz() == 0 || m.nz() != m.ny() * one.nz())
      fail("initial_latent has {} entries; with {} outputs and {} modes of each it must have {}", m.nz(), m.ny(),
           one.nz(), m.ny() * one.nz());
    if (!m.initial_latent.isZero(0.0)) fail("initial_latent must be zero: no vector is known before the first sample");
    check_linear_latent(one);
    check_map(m);
    Eigen::VectorXd reads(m.nz() + m.nr());
    reads << largest_latent(one).replicate(m.ny(), 1), largest_readings(m);
    check_sums(own_part<Carried>(m).inverse_map, reads, "inverse_map");
  }

  std::vector<Named<Network>> networks(Model& m) const override {
    Network& map = own_part<Carried>(m).inverse_map;
    return {{"inverse_map", &map, reads_of(map, m)}};
  }
  Network* inverse_map(Model& m) const override { return &own_part<Carried>(m).inverse_map; }
  bool estimates_directions(const Model& m) const override { return own_part<Carried>(m).unit_length; }
  std::optional<double> fastest_mode(const Model& m) const override {
    return fastest_driven_mode(own_part<Carried>(m).component);
  }
  std::optional<double> slowest_mode(const Model& m) const override {
    return slowest_driven_mode(own_part<Carried>(m).component);
  }

  std::unique_ptr<ReferenceDynamics<float>> dynamics_in_float(const Model& m, Activations) const override {
    return std::make_unique<CarriedDynamics<float>>(m);
  }
  std::unique_ptr<ReferenceDynamics<double>> dynamics_in_double(const Model& m, Activations) const override {
    return std::make_unique<CarriedDynamics<double>>(m);
  }

  Abilities abilities() const override { return {.c99 = true}; }
  std::unique_ptr<CppStructure> cpp(const ExportSource& source) const override {
    return std::make_unique<CarriedHeader>(source);
  }
  std::map<std::string, std::string> c99(const ExportSource& source) const override {
    const Carried& own = own_part<Carried>(source.model);
    const Initialiser& init = source.init;
    const Model one = component_of(source.model);
    const StepMatrices step = latent_step(one, one.sample_period_s);
    const Eigen::MatrixXd weights = vector_weights(source.model, source.folded.network("inverse_map"));
    return {{"LATENT", "c99/carried.c.in"},
            {"ARITHMETIC", ""},
            {"MAP", std::string(embedded_text("c99/carried_map.c.in"))},
            {"STEP_DT_COST", "Some 60 operations a mode and 100 more"},
            {"MODES", std::to_string(one.nz())},
            {"COMPLEX", own.component.pairs > 0 ? "true" : ""},
            {"PAIRS", std::to_string(own.component.pairs)},
            {"FIRST_ORDER", source.model.hold == Hold::kZeroOrder ? "" : "true"},
            {"FIRST", own.component.starts_steady ? "    settle(o);\n" : ""},
            {"USUAL_DOUBLINGS", std::to_string(CarriedLimits::kUsualDoublings)},
            {"MOST_TURN_DOUBLINGS", std::to_string(CarriedLimits::kMostDoublings)},
            {"TWELFTH", init(1.0 / 12.0, "a twelfth")},
            {"A_MINUS_1", init.vector(step.a_minus_1, "A")},
            {"B0", init.vector(step.b0, "B0")},
            {"B1", init.vector(step.b1, "B1")},
            {"EIGENVALUES", init.vector(own.component.eigenvalues, "eigenvalues")},
            {"INJECTION", init.vector(own.component.output_injection, "output_injection")},
            {"STEADY_GAIN", init.vector(steady_gain(one), "steady_gain")},
            {"FEATURES", std::to_string(weights.cols())},
            {"WEIGHTS", init.matrix(weights, "inverse_map")},
            {"UNIT_LENGTH", own.unit_length ? "true" : ""}};
  }
};

}  // namespace

const StructureModule& carried_module() {
  static const CarriedModule module;
  return module;
}

}  // namespace nlo::codegen
