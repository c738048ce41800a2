// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <nlo/explicit_rk.h>

#include <utility>

#include "codegen/model/field_checks.h"
#include "codegen/model/hold.h"
#include "codegen/model/latent_step.h"
#include "codegen/model/model_fields.h"
#include "codegen/structures/c99_pieces.h"
#include "codegen/structures/driven_dynamics.h"
#include "codegen/structures/linear_latent_fields.h"

namespace nlo::codegen {
namespace {

class DrivenKklHeader final : public KklHeader {
 public:
  explicit DrivenKklHeader(const ExportSource& source)
      : KklHeader(source),
        own_(own_part<DrivenKkl>(source.model)),
        forced_(forced_latent_step(source.model, source.model.sample_period_s)),
        nu_(source.model.nu()) {}

  std::string title() const override { return "a learned state observer (driven Kazantzis-Kravaris/Luenberger)"; }
  std::string description() const override {
    return KklHeader::description() +
           fmt::format(
               "// Inputs act by phi(z) u = dT/dx g(x_hat) u, stepped at order 4; D and F are stepped exactly. {}.\n"
               "// Forward map T: {}.\n",
               own_.input_hold == Hold::kZeroOrder ? "u has acted since the last sample"
                                                   : "u is a ramp between samples",
               forward_map().description());
  }
  std::string header() const override { return "driven_kkl_observer.h"; }
  std::vector<CppNetwork> networks() const override { return {inverse_map(), forward_map()}; }
  std::string model_type() const override {
    return fmt::format(
        "DrivenKklModel<{}, {}, {}, {}, {}, {},  // n_x, n_y, n_z, n_u, complex pairs\n"
        "                             {},\n"
        "                             {}>;\n",
        init_.scalar_name(), nx_, ny_, nz_, nu_, latent_.pairs, inverse_map().map_type(init_),
        forward_map().map_type(init_));
  }
  std::string observer() const override { return "DrivenKklObserver"; }
  std::string leading_fields() const override {
    const auto& w = forced_.weights;
    std::string text = fmt::format("    .input_hold = {},\n", hold_identifier(own_.input_hold)) + latent_fields();
    text += "    .forced = {  // coefficients of phi(z) u over one sample period, per stage\n        .half = " +
            step(forced_.half, 17) + ",\n        .weights = {";
    bool first = true;
    for (const auto& [name, weight] : {std::pair{"stage2", &w.stage2},
                                       {"stage3_1", &w.stage3_1},
                                       {"stage3_2", &w.stage3_2},
                                       {"stage4_1", &w.stage4_1},
                                       {"stage4_3", &w.stage4_3},
                                       {"end_1", &w.end_1},
                                       {"end_23", &w.end_23},
                                       {"end_4", &w.end_4}}) {
      text += fmt::format("{}.{} = {{{}}}", first ? "" : ",\n                    ", name, init_.vector(*weight, name));
      first = false;
    }
    return text + "},\n    },\n";
  }
  std::string trailing_fields() const override {
    std::string constant, linear;
    for (Eigen::Index i = 0; i < nu_; ++i) {
      const DenseLayer& g = own_.input_field;
      constant += (i > 0 ? ", " : "") + init_.vector(g.bias.segment(i * nx_, nx_), "drive.input_field.bias");
      linear += (i > 0 ? ", " : "") + init_.matrix(g.weights.middleRows(i * nx_, nx_), "drive.input_field.weights");
    }
    return fmt::format("    .input_field = {{.constant = {{{}}},\n                    .linear = {{{}}}}},\n", constant,
                       linear) +
           KklHeader::trailing_fields();
  }

  Eigen::Index step_multiply_adds() const override {
    return 2 * linear_multiply_adds() + 8 * (nz_ + 2 * latent_.pairs) +
           4 * (inverse_map().multiply_adds() + nu_ * nx_ * (nx_ + 1) + 2 * forward_map().multiply_adds());
  }
  Eigen::Index step_activations() const override {
    return 4 * (inverse_map().activations() + forward_map().activations());
  }
  Eigen::Index own_scalars() const override {
    return KklHeader::own_scalars() + (nz_ + 2 * nz_ * nr_) + 8 * nz_ + nu_ * nx_ * (nx_ + 1);
  }

 private:
  CppNetwork forward_map() const { return network("drive.forward_map", "ForwardLayer", "ForwardNetwork", "x"); }

  const DrivenKkl& own_;
  const ForcedStepMatrices forced_;
  const Eigen::Index nu_;
};

void check_inputs(const Model& m) {
  const DrivenKkl& own = own_part<DrivenKkl>(m);
  check_channels(own.inputs, "drive.inputs");
  for (std::size_t i = 0; i < own.inputs.size(); ++i)
    if (own.inputs[i].wrap != 0.0)
      fail("drive.inputs[{}].wrap is {}; an input is not unwrapped: write 0", i, own.inputs[i].wrap);
  if (own.input_hold == Hold::kRk4)
    fail("drive.input_hold is unknown; use zero_order (a command that has acted since the last sample) or first_order");
  const Eigen::Index entries = Eigen::Index{m.nx()} * m.nu();
  check_shape(own.input_field.weights, entries, m.nx(), "drive.input_field.weights", "n_x n_u x n_x");
  check_shape(own.input_field.bias, entries, "drive.input_field.bias", "n_x n_u");
  check_network(own.forward_map, m.nx(), m.nz(), "drive.forward_map", "n_u x n_x");
}

/// Returns the initialiser of a Linear of templates/c99/kkl.c.in.
std::string c99_linear_step(const Model& m, const StepMatrices& step, const Initialiser& init) {
  return "{" + init.vector(step.a_minus_1, "A") + ",\n     " + init.matrix(step.b0, "B0") +
         (m.hold == Hold::kZeroOrder ? "" : ",\n     " + init.matrix(step.b1, "B1")) + "}";
}

class DrivenKklModule final : public StructureModule {
 public:
  std::string_view name() const override { return "driven_kkl"; }

  std::vector<const char*> keys() const override {
    return {"starts_steady", "relative_outputs", "pairs", "eigenvalues", "output_injection", "inverse_map", "drive"};
  }
  void read(const Field& file, Model& m) const override {
    DrivenKkl& own = m.structure.emplace<DrivenKkl>();
    read_linear_latent(file, own.latent);
    const Field drive = file["drive"];
    drive.allow_only({"inputs", "input_hold", "input_field", "forward_map"});
    own.inputs = channels(drive["inputs"]);
    own.input_hold = hold(drive["input_hold"]);
    own.input_field = dense(drive["input_field"]);
    own.forward_map = network(drive["forward_map"]);
    own.inverse_map = network(file["inverse_map"]);
  }
  void write(const Model& m, JsonObject& file) const override {
    const DrivenKkl& own = own_part<DrivenKkl>(m);
    write_linear_latent(own.latent, file);
    JsonObject drive(file.inner());
    drive.channels("inputs", own.inputs);
    drive.text("input_hold", hold_name(own.input_hold));
    drive.dense("input_field", own.input_field);
    drive.network("forward_map", own.forward_map);
    file.field("drive", drive.text());
    file.network("inverse_map", own.inverse_map);
  }
  void check(const Model& m) const override {
    check_linear_latent(m);
    check_latent_map(m);
    check_inputs(m);
  }

  std::vector<Named<Network>> networks(Model& m) const override {
    DrivenKkl& own = own_part<DrivenKkl>(m);
    return {{"inverse_map", &own.inverse_map, reads_of(own.inverse_map, m)},
            {"drive.forward_map", &own.forward_map, m.nx()}};
  }
  Network* inverse_map(Model& m) const override { return &own_part<DrivenKkl>(m).inverse_map; }
  LinearLatent* linear_latent(Model& m) const override { return &own_part<DrivenKkl>(m).latent; }
  const std::vector<Channel>& inputs(const Model& m) const override { return own_part<DrivenKkl>(m).inputs; }
  Hold input_hold(const Model& m) const override { return own_part<DrivenKkl>(m).input_hold; }
  bool reads_inputs() const override { return false; }
  Structure without_inputs(const Model& m) const override { return Kkl(own_part<DrivenKkl>(m)); }
  std::optional<double> fastest_mode(const Model& m) const override {
    return fastest_driven_mode(own_part<DrivenKkl>(m).latent);
  }
  std::optional<double> slowest_mode(const Model& m) const override {
    return slowest_driven_mode(own_part<DrivenKkl>(m).latent);
  }

  std::unique_ptr<ReferenceDynamics<float>> dynamics_in_float(const Model& m, Activations a) const override {
    return std::make_unique<DrivenDynamics<float>>(m, a);
  }
  std::unique_ptr<ReferenceDynamics<double>> dynamics_in_double(const Model& m, Activations a) const override {
    return std::make_unique<DrivenDynamics<double>>(m, a);
  }

  bool may_diverge() const override { return true; }
  std::unique_ptr<CppStructure> cpp(const ExportSource& source) const override {
    return std::make_unique<DrivenKklHeader>(source);
  }
  Abilities abilities() const override { return {.c99 = true}; }
  std::map<std::string, std::string> c99(const ExportSource& source) const override {
    const DrivenKkl& own = own_part<DrivenKkl>(source.model);
    const Initialiser& init = source.init;
    const int nx = source.model.nx(), nu = source.model.nu();
    std::map<std::string, std::string> values = c99_of_linear_latent(source);
    const ForcedStepMatrices forced = forced_latent_step(source.model, source.model.sample_period_s);
    Eigen::MatrixXd weights(8, source.model.nz()), field(nu, nx);
    const auto& w = forced.weights;
    weights << w.stage2.transpose(), w.stage3_1.transpose(), w.stage3_2.transpose(), w.stage4_1.transpose(),
        w.stage4_3.transpose(), w.end_1.transpose(), w.end_23.transpose(), w.end_4.transpose();
    std::string slopes;
    for (int i = 0; i < nu; ++i) {
      field.row(i) = own.input_field.bias.segment(i * nx, nx).transpose();
      slopes += (i > 0 ? ", " : "") +
                init.matrix(own.input_field.weights.middleRows(i * nx, nx), "drive.input_field.weights");
    }
    for (const auto& [key, value] : std::map<std::string, std::string>{
             {"LATENT", "c99/driven_kkl.c.in"},
             {"LINEAR", "c99/kkl.c.in"},
             {"STEP_DT_COST", "For each sample period as much, and some 400 operations per latent state"},
             {"LINEAR_STEP", "Linear"},
             {"STEP_TABLE", ""},
             {"MAKE_LINEAR", "make_linear"},
             {"ADVANCE_LINEAR", "advance_linear"},
             {"COMPLEX", "true"},
             {"DIVERGES", "true"},
             {"LAST_STATUS", "DIVERGED"},
             {"LONGEST_GAP", std::to_string(kMostPieces)},
             {"Y_PART", c99_part(source.model.hold, "part", init)},
             {"U_PART", c99_part(own.input_hold, "part", init)},
             {"FULL", c99_linear_step(source.model, source.folded.step, init)},
             {"HALF", c99_linear_step(source.model, forced.half, init)},
             {"FORCED", init.matrix(weights, "A")},
             {"SIXTH", init(1.0 / 6, "a sixth")},
             {"INPUT_FIELD", init.matrix(field, "drive.input_field.bias")},
             {"INPUT_FIELD_SLOPE", "{" + slopes + "}"}})
      values[key] = value;
    return values;
  }
};

}  // namespace

const StructureModule& driven_kkl_module() {
  static const DrivenKklModule module;
  return module;
}

}  // namespace nlo::codegen
