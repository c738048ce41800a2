// SPDX-License-Identifier: MIT
#include "codegen/model/window.h"

#include <fmt/format.h>
#include <nlo/explicit_rk.h>

#include "codegen/model/checks.h"
#include "codegen/model/hold.h"
#include "codegen/model/model_fields.h"
#include "codegen/reference/integrate.h"
#include "codegen/structures/c99_pieces.h"
#include "codegen/structures/module.h"

namespace nlo::codegen {
namespace {

template <class Scalar>
class WindowDynamics final : public ReferenceDynamics<Scalar> {
 public:
  using typename ReferenceDynamics<Scalar>::Vector;
  using typename ReferenceDynamics<Scalar>::Matrix;

  explicit WindowDynamics(const Model& m)
      : samples_(own_part<Window>(m).samples), hold_(m.hold), sample_period_s_(m.sample_period_s) {}

  void start(Matrix& z, const Matrix& y) const override {
    for (Eigen::Index r = 0; r < z.rows(); ++r) z.row(r) = y.row(r / samples_);
  }

  void advance(Vector& z, const Between<Scalar>& over, double dt_s) override {
    const int steps = pieces_of(dt_s, sample_period_s_);
    for (int s = 1; s <= steps; ++s) {
      const Vector y = s == steps
                           ? over.y_next
                           : held(hold_, over.y, over.y_next, static_cast<Scalar>(s) / static_cast<Scalar>(steps));
      for (Eigen::Index j = 0; j < y.size(); ++j) {
        auto row = z.segment(j * samples_, samples_);
        row.tail(samples_ - 1) = row.head(samples_ - 1).eval();
        row(0) = y(j);
      }
    }
  }

  double longest_step_s() const override { return kMostPieces * sample_period_s_; }

  Matrix slope(const Matrix&, const Matrix&, const Vector&) const override {
    throw Error("a window observer has no differential equation; give it sampled measurements");
  }

 private:
  Eigen::Index samples_;
  Hold hold_;
  double sample_period_s_;
};

class WindowHeader final : public CppStructureBase {
 public:
  explicit WindowHeader(const ExportSource& source)
      : CppStructureBase(source), samples_(own_part<Window>(source.model).samples) {}

  std::string title() const override { return "a learned state observer (a map of the last measurements)"; }
  std::string description() const override {
    return fmt::format("// Latent state: the last {} measurements of each output. Map T*: {}.\n", samples_,
                       inverse_map().description()) +
           input_comment();
  }
  std::string header() const override { return "window_observer.h"; }
  std::vector<CppNetwork> networks() const override { return {inverse_map()}; }
  std::string types() const override {
    return fmt::format(
        "using Model = WindowModel<{}, {}, {}, {}, {}{}>;  // n_x, n_y, samples{}\n"
        "using Observer = WindowObserver<Model>;\n",
        init_.scalar_name(), nx_, ny_, samples_, inverse_map().map_type(init_), input_arguments(),
        read_inputs_ > 0 ? ", T*, n_u" : "");
  }
  std::string leading_fields() const override { return fmt::format("    .hold = {},\n", hold_identifier(m_.hold)); }

  Eigen::Index step_multiply_adds() const override { return 0; }
  Eigen::Index step_activations() const override { return 0; }
  Eigen::Index own_scalars() const override { return 1; }  // stale_after and hold share one

 private:
  const int samples_;
};

class WindowModule final : public StructureModule {
 public:
  std::string_view name() const override { return "window"; }

  std::vector<const char*> keys() const override { return {"samples", "inverse_map"}; }
  void read(const Field& file, Model& m) const override {
    m.structure = Window{small_integer(file["samples"]), network(file["inverse_map"])};
  }
  void write(const Model& m, JsonObject& file) const override {
    const Window& own = own_part<Window>(m);
    file.field("samples", std::to_string(own.samples));
    file.network("inverse_map", own.inverse_map);
  }
  void check(const Model& m) const override {
    const Window& own = own_part<Window>(m);
    check_no_angles(m);
    if (own.samples < 1 || own.samples * m.nr() != m.nz())
      fail("samples is {}; with {} outputs{}, {} latent states must be that many of each", own.samples, m.ny(),
           !m.inputs.empty() ? fmt::format(" and {} inputs", static_cast<int>(m.inputs.size())) : "", m.nz());
    check_network(own.inverse_map, m.nz(), m.nx(), "inverse_map", "n_u x n_z");
    check_sums(own.inverse_map, largest_readings(m).replicate(own.samples, 1), "inverse_map");
  }

  std::vector<Named<Network>> networks(Model& m) const override {
    return {{"inverse_map", &own_part<Window>(m).inverse_map, m.nz()}};
  }
  Network* inverse_map(Model& m) const override { return &own_part<Window>(m).inverse_map; }

  std::unique_ptr<ReferenceDynamics<float>> dynamics_in_float(const Model& m, Activations) const override {
    return std::make_unique<WindowDynamics<float>>(m);
  }
  std::unique_ptr<ReferenceDynamics<double>> dynamics_in_double(const Model& m, Activations) const override {
    return std::make_unique<WindowDynamics<double>>(m);
  }

  std::unique_ptr<CppStructure> cpp(const ExportSource& source) const override {
    return std::make_unique<WindowHeader>(source);
  }
  Abilities abilities() const override { return {.c99 = true, .int16 = true, .whole_periods = true}; }
  std::map<std::string, std::string> c99(const ExportSource& source) const override {
    return {{"LATENT", "c99/window.c.in"},
            {"LONGEST_GAP", std::to_string(kMostPieces)},
            {"PHI", ""},
            {"FIRST", "    fill(o);\n"},
            {"STEP_DT_COST", "For each sample period as much"},
            {"SAMPLES", std::to_string(own_part<Window>(source.model).samples)},
            {"PART", c99_part(source.model.hold, "(Scalar)s / (Scalar)step->samples", source.init)}};
  }
};

}  // namespace

const StructureModule& window_module() {
  static const WindowModule module;
  return module;
}

}  // namespace nlo::codegen
