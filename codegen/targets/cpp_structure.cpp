// SPDX-License-Identifier: MIT
#include "codegen/targets/cpp_structure.h"

#include <fmt/format.h>

#include <utility>

namespace nlo::codegen {
namespace {

std::string hold_of(const std::string& name) {
  return name == "zero_order" ? "Hold::kZeroOrder" : name == "rk4" ? "Hold::kRk4" : "Hold::kFirstOrder";
}

/// What the structures share.
class Base : public CppStructure {
 public:
  Base(const Model& model, const FoldedModel& folded, const Initialiser& init,
       const QuantisedNetwork* quantised = nullptr)
      : m_(model), f_(folded), init_(init), quantised_(quantised), nx_(model.nx()), ny_(model.ny()), nz_(model.nz()) {}

  std::string trailing_fields() const override {
    std::string text;
    for (const CppNetwork& n : networks()) text += n.initialiser(init_, member(n));
    return text;
  }
  Eigen::Index estimate_multiply_adds() const override { return inverse_map().multiply_adds(); }
  Eigen::Index estimate_activations() const override { return inverse_map().activations(); }

 protected:
  CppNetwork inverse_map() const {
    return {f_.inverse_map, "inverse_map", "Layer", "Network", "InverseMap", f_.reads_output ? "[z; y]" : "z",
            quantised_};
  }
  static std::string member(const CppNetwork& n) { return n.field.substr(n.field.rfind('.') + 1); }

  const Model& m_;
  const FoldedModel& f_;
  const Initialiser& init_;
  const QuantisedNetwork* quantised_;
  const Eigen::Index nx_, ny_, nz_;
};

/// (16)
class Kkl : public Base {
 public:
  using Base::Base;
  std::string title() const override { return "a learned state observer (Kazantzis-Kravaris/Luenberger)"; }
  std::string description() const override {
    return fmt::format("// Latent state: {} ({} complex pairs), {} hold. Inverse map T*: {}.\n", nz_, m_.pairs, m_.hold,
                       inverse_map().description());
  }
  std::string header() const override { return "kkl_observer.h"; }
  std::vector<CppNetwork> networks() const override { return {inverse_map()}; }
  std::string types() const override {
    return fmt::format(
        "using Model = KklModel<{}, {}, {}, {}, {}, {}>;  // n_x, n_y, n_z, complex pairs\n"
        "using Observer = KklObserver<Model>;\n",
        init_.scalar_name(), nx_, ny_, nz_, m_.pairs, inverse_map().map_type(init_));
  }
  std::string leading_fields() const override { return latent(); }

  Eigen::Index step_multiply_adds() const override { return linear_multiply_adds(); }
  Eigen::Index step_activations() const override { return 0; }
  Eigen::Index own_scalars() const override {
    // eigenvalues, F, A, B0, B1, S, initial; stale_after, hold and starts_steady by alignment
    return nz_ + nz_ * ny_ + (nz_ + 2 * nz_ * ny_) + nz_ * ny_ + nz_ + 3;
  }

 protected:
  Eigen::Index linear_multiply_adds() const { return nz_ + 2 * m_.pairs + 2 * nz_ * ny_; }

  std::string latent() const {
    std::string text = "    .latent = {\n";
    text += fmt::format("        .hold = {},\n", hold_of(m_.hold));
    text += fmt::format("        .eigenvalues = {},  // 1/s\n", init_.vector(m_.eigenvalues, "eigenvalues"));
    text += fmt::format("        .output_injection = {},\n", init_.matrix(m_.output_injection, "output_injection"));
    text += "        .step = " + step(f_.step, 17) + ",\n";
    text += fmt::format("        .steady_gain = {},\n", init_.matrix(f_.steady_gain, "steady_gain"));
    text += fmt::format("        .initial = {},\n", init_.vector(m_.initial_latent, "initial_latent"));
    text += fmt::format("        .starts_steady = {},\n", m_.starts_steady);
    if (!m_.relative_outputs.empty()) {
      std::string list;
      for (int j = 0; j < m_.ny(); ++j) list += fmt::format("{}{}", j == 0 ? "" : ", ", is_relative(m_, j));
      text += fmt::format("        .relative = {{{}}},\n", list);
    }
    return text + "    },\n";
  }

  std::string step(const LatentStep& step, std::size_t indent) const {
    const std::string space(indent, ' ');
    return fmt::format("{{.a_minus_1 = {},\n{}.b0 = {},\n{}.b1 = {}}}", init_.vector(step.a_minus_1, "A"), space,
                       init_.matrix(step.b0, "B0"), space, init_.matrix(step.b1, "B1"));
  }
};

/// (24)-(25)
class DrivenKkl final : public Kkl {
 public:
  DrivenKkl(const Model& model, const FoldedModel& folded, const Initialiser& init)
      : Kkl(model, folded, init), nu_(model.nu()) {}

  std::string title() const override { return "a learned state observer (driven Kazantzis-Kravaris/Luenberger)"; }
  std::string description() const override {
    return Kkl::description() +
           fmt::format(
               "// Inputs act by phi(z) u = dT/dx g(x_hat) u, order 4 beside exact D and F; {}.\n"
               "// Forward map T: {}.\n",
               m_.drive->input_hold == "zero_order" ? "u has acted since the last sample" : "u is a ramp",
               forward_map().description());
  }
  std::string header() const override { return "driven_kkl_observer.h"; }
  std::vector<CppNetwork> networks() const override { return {inverse_map(), forward_map()}; }
  std::string types() const override {
    return fmt::format(
        "using Model = DrivenKklModel<{}, {}, {}, {}, {}, {},  // n_x, n_y, n_z, n_u, complex pairs\n"
        "                             {},\n"
        "                             {}>;\n"
        "using Observer = DrivenKklObserver<Model>;\n",
        init_.scalar_name(), nx_, ny_, nz_, nu_, m_.pairs, inverse_map().map_type(init_),
        forward_map().map_type(init_));
  }
  std::string leading_fields() const override {
    const auto& w = f_.forced.weights;
    std::string text = fmt::format("    .input_hold = {},\n", hold_of(m_.drive->input_hold)) + latent();
    text += "    .forced = {  // how phi(z) u acts over one sample period, stage by stage\n        .half = " +
            step(f_.forced.half, 17) + ",\n        .weights = {";
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
      const DenseLayer& g = m_.drive->input_field;
      constant += (i > 0 ? ", " : "") + init_.vector(g.bias.segment(i * nx_, nx_), "drive.input_field.bias");
      linear += (i > 0 ? ", " : "") + init_.matrix(g.weights.middleRows(i * nx_, nx_), "drive.input_field.weights");
    }
    return fmt::format("    .input_field = {{.constant = {{{}}},\n                    .linear = {{{}}}}},\n", constant,
                       linear) +
           Base::trailing_fields();
  }

  Eigen::Index step_multiply_adds() const override {
    return 2 * linear_multiply_adds() + 8 * (nz_ + 2 * m_.pairs) +
           4 * (inverse_map().multiply_adds() + nu_ * nx_ * (nx_ + 1) + 2 * forward_map().multiply_adds());
  }
  Eigen::Index step_activations() const override {
    return 4 * (inverse_map().activations() + forward_map().activations());
  }
  Eigen::Index own_scalars() const override {
    return Kkl::own_scalars() + (nz_ + 2 * nz_ * ny_) + 8 * nz_ + nu_ * nx_ * (nx_ + 1);
  }

 private:
  CppNetwork forward_map() const {
    return {f_.forward_map, "drive.forward_map", "ForwardLayer", "ForwardNetwork", "LearnedMap", "x"};
  }

  const Eigen::Index nu_;
};

/// (15)
class Luenberger final : public Base {
 public:
  using Base::Base;
  std::string title() const override { return "a state observer (Luenberger-like, with a learned nonlinearity)"; }
  std::string description() const override {
    return fmt::format("// x_hat' = A x_hat + g_hat(x_hat) + G (y - C x_hat), RK4, {} hold. g_hat: {}.\n", m_.hold,
                       nonlinearity().description());
  }
  std::string header() const override { return "luenberger_observer.h"; }
  std::vector<CppNetwork> networks() const override { return {nonlinearity()}; }
  std::string types() const override {
    return fmt::format(
        "using Model = LuenbergerModel<{}, {}, {}, {}>;  // n_x, n_y\n"
        "using Observer = LuenbergerObserver<Model>;\n",
        init_.scalar_name(), nx_, ny_, nonlinearity().map_type(init_));
  }
  std::string leading_fields() const override {
    return fmt::format(
        "    .hold = {},\n"
        "    .error_matrix = {},  // A - G C\n"
        "    .gain = {},  // G\n"
        "    .initial = {},\n",
        hold_of(m_.hold), init_.matrix(f_.error_matrix, "luenberger.state_matrix"),
        init_.matrix(m_.luenberger->gain, "luenberger.gain"), init_.vector(m_.initial_latent, "initial_latent"));
  }

  Eigen::Index step_multiply_adds() const override { return 4 * (nx_ * (nx_ + ny_) + nonlinearity().multiply_adds()); }
  Eigen::Index step_activations() const override { return 4 * nonlinearity().activations(); }
  Eigen::Index estimate_multiply_adds() const override { return 0; }
  Eigen::Index estimate_activations() const override { return 0; }
  Eigen::Index own_scalars() const override { return nx_ * (nx_ + ny_) + nx_ + 1; }  // stale_after and hold share one

 private:
  CppNetwork nonlinearity() const {
    return {f_.nonlinearity, "luenberger.nonlinearity", "Layer", "Network", "LearnedMap", "x_hat"};
  }
};

/// (11)
class General final : public Base {
 public:
  using Base::Base;
  std::string title() const override { return "a learned state observer (general: dz/dt = F(z, y))"; }
  std::string description() const override {
    return fmt::format("// Latent state: {}, RK4, {} hold. F: {}. G: {}.\n", nz_, m_.hold, dynamics().description(),
                       inverse_map().description());
  }
  std::string header() const override { return "general_observer.h"; }
  std::vector<CppNetwork> networks() const override { return {dynamics(), inverse_map()}; }
  std::string types() const override {
    return fmt::format(
        "using Model = GeneralModel<{}, {}, {}, {}, {}, {}>;  // n_x, n_y, n_z\n"
        "using Observer = GeneralObserver<Model>;\n",
        init_.scalar_name(), nx_, ny_, nz_, dynamics().map_type(init_), inverse_map().map_type(init_));
  }
  std::string leading_fields() const override {
    return fmt::format("    .hold = {},\n    .initial = {},\n", hold_of(m_.hold),
                       init_.vector(m_.initial_latent, "initial_latent"));
  }

  Eigen::Index step_multiply_adds() const override { return 4 * dynamics().multiply_adds(); }
  Eigen::Index step_activations() const override { return 4 * dynamics().activations(); }
  Eigen::Index own_scalars() const override { return nz_ + 1; }  // stale_after and hold share one

 private:
  CppNetwork dynamics() const {
    return {f_.dynamics, "dynamics", "DynamicsLayer", "DynamicsNetwork", "LearnedMap", "[z; y]"};
  }
};

}  // namespace

std::unique_ptr<CppStructure> cpp_structure(const Model& m, const FoldedModel& folded, const Initialiser& init,
                                            const QuantisedNetwork* quantised) {
  if (m.luenberger) return std::make_unique<Luenberger>(m, folded, init);
  if (m.dynamics) return std::make_unique<General>(m, folded, init);
  if (m.drive) return std::make_unique<DrivenKkl>(m, folded, init);
  return std::make_unique<Kkl>(m, folded, init, quantised);
}

}  // namespace nlo::codegen
