// SPDX-License-Identifier: MIT
#include "codegen/base/linear_algebra.h"
#include "codegen/model/luenberger.h"

#include <fmt/format.h>
#include <nlo/explicit_rk.h>

#include <cmath>
#include <complex>
#include <string>

#include "codegen/model/field_checks.h"
#include "codegen/model/hold.h"
#include "codegen/model/model_fields.h"
#include "codegen/reference/integrate.h"
#include "codegen/structures/c99_pieces.h"
#include "codegen/structures/structure_module.h"

namespace nlo::codegen {
namespace {

/// Returns [G, B], which read [y; u].
Eigen::MatrixXd reading_gain(const Luenberger& l, Eigen::Index inputs) {
  Eigen::MatrixXd both(l.gain.rows(), l.gain.cols() + inputs);
  both.leftCols(l.gain.cols()) = l.gain;
  if (inputs > 0) both.rightCols(inputs) = l.input_matrix;
  return both;
}

/// Returns A - G C.
Eigen::MatrixXd error_matrix(const Luenberger& l) {
  return l.state_matrix - ordered_product(l.gain, l.output_matrix);
}

template <class Scalar>
class LuenbergerDynamics final : public ReferenceDynamics<Scalar> {
 public:
  using typename ReferenceDynamics<Scalar>::Vector;
  using typename ReferenceDynamics<Scalar>::Matrix;

  LuenbergerDynamics(const Model& m, Activations activations)
      : hold_(m.hold),
        sample_period_s_(m.sample_period_s),
        state_matrix_(own_part<Luenberger>(m).state_matrix.cast<Scalar>()),
        output_matrix_(own_part<Luenberger>(m).output_matrix.cast<Scalar>()),
        gain_(own_part<Luenberger>(m).gain.cast<Scalar>()),
        input_matrix_(own_part<Luenberger>(m).input_matrix.cast<Scalar>()),
        nonlinearity_(own_part<Luenberger>(m).nonlinearity, activations) {}

  void advance(Vector& z, const Between<Scalar>& over, double dt_s) override {
    integrate(*this, hold_, sample_period_s_, z, over, dt_s);
  }
  double longest_step_s() const override { return kMostPieces * sample_period_s_; }
  Matrix slope(const Matrix& z, const Matrix& y, const Vector&) const override {
    const Eigen::Index ny = gain_.cols(), nu = y.rows() - ny;
    Matrix slope = state_matrix_ * z + nonlinearity_(z) + gain_ * (y.topRows(ny) - output_matrix_ * z);
    if (nu > 0) slope += input_matrix_ * y.bottomRows(nu);
    return slope;
  }

 private:
  Hold hold_;
  double sample_period_s_;
  Matrix state_matrix_, output_matrix_, gain_, input_matrix_;
  ReferenceNetwork<Scalar> nonlinearity_;
};

class LuenbergerHeader final : public CppStructureBase {
 public:
  using CppStructureBase::CppStructureBase;
  std::string title() const override { return "a state observer (Luenberger-like, with a learned nonlinearity)"; }
  std::string description() const override {
    return fmt::format("// x_hat' = A x_hat + {}g_hat(x_hat) + G (y - C x_hat), RK4, {} hold. g_hat: {}.\n",
                       read_inputs_ > 0 ? "B u + " : "", hold_name(m_.hold), nonlinearity().description()) +
           input_comment();
  }
  std::string header() const override { return "luenberger_observer.h"; }
  std::vector<CppNetwork> networks() const override { return {nonlinearity()}; }
  std::string model_type() const override {
    return fmt::format("LuenbergerModel<{}, {}, {}, {}{}>;  // n_x, n_y{}\n", init_.scalar_name(), nx_, ny_,
                       nonlinearity().map_type(init_), input_arguments(), read_inputs_ > 0 ? ", g_hat, n_u" : "");
  }
  std::string observer() const override { return "LuenbergerObserver"; }
  std::string leading_fields() const override {
    return fmt::format(
        "    .hold = {},\n"
        "    .error_matrix = {},  // A - G C\n"
        "    .gain = {},  // {}\n"
        "    .initial = {},\n",
        hold_identifier(m_.hold), init_.matrix(error_matrix(own_part<Luenberger>(m_)), "luenberger.state_matrix"),
        init_.matrix(reading_gain(own_part<Luenberger>(m_), read_inputs_), "luenberger.gain"),
        read_inputs_ > 0 ? "[G, B]" : "G", init_.vector(m_.initial_latent, "initial_latent"));
  }

  Eigen::Index step_multiply_adds() const override { return 4 * (nx_ * (nx_ + nr_) + nonlinearity().multiply_adds()); }
  Eigen::Index step_activations() const override { return 4 * nonlinearity().activations(); }
  Eigen::Index estimate_multiply_adds() const override { return 0; }
  Eigen::Index estimate_activations() const override { return 0; }
  Eigen::Index own_scalars() const override { return nx_ * (nx_ + nr_) + nx_ + 1; }  // stale_after and hold share one

 private:
  CppNetwork nonlinearity() const { return network("luenberger.nonlinearity", "Layer", "Network", "x_hat"); }
};

std::string text(std::complex<double> value) {
  if (value.imag() == 0.0) return fmt::format("{:.4g}", value.real());
  return fmt::format("{:.4g} {} {:.4g}i", value.real(), value.imag() < 0.0 ? '-' : '+', std::abs(value.imag()));
}

// Gaps are divided into steps of at most this many sample periods (nlo/explicit_rk.h).
constexpr double kLongestStep = 1.5;

/// Checks that A - G C is Hurwitz and within the stable region of the Runge-Kutta method at the sample period. The
/// effect of g_hat is not checked.
void check_luenberger(const Model& m) {
  const Luenberger& l = own_part<Luenberger>(m);
  const int nx = m.nx();
  if (m.nz() != nx)
    fail(
        "initial_latent has {} entries; it must have {} (n_x: the latent state of a luenberger observer is its "
        "estimate)",
        m.nz(), nx);
  check_shape(l.state_matrix, nx, nx, "luenberger.state_matrix", "n_x x n_x");
  check_shape(l.output_matrix, m.ny(), nx, "luenberger.output_matrix", "n_y x n_x");
  check_shape(l.gain, nx, m.ny(), "luenberger.gain", "n_x x n_y");
  if (!m.inputs.empty() || l.input_matrix.size() != 0)
    check_shape(l.input_matrix, nx, static_cast<int>(m.inputs.size()), "luenberger.input_matrix", "n_x x n_u");
  check_network(l.nonlinearity, nx, nx, "luenberger.nonlinearity", "n_u x n_x");

  for (const std::complex<double> lambda : eigenvalues(l.state_matrix - l.gain * l.output_matrix)) {
    if (!(lambda.real() < 0.0))
      fail(
          "luenberger.gain leaves A - G C with the eigenvalue {}; its real part must be negative (A - G C must be "
          "Hurwitz): choose a gain that makes it so",
          text(lambda));
    const double h = kLongestStep * m.sample_period_s;
    const auto mode = discretise(Hold::kRk4, Complex<double>{lambda.real(), lambda.imag()}, h);
    const double radius = std::abs(std::complex<double>(1.0 + mode.a_minus_1.re, mode.a_minus_1.im));
    if (!(radius < 1.0))
      fail(
          "luenberger.gain gives A - G C the eigenvalue {}, too fast for a Runge-Kutta step of {:.4g} s (|R| = {:.3g}; "
          "1.5 sample periods, which jitter may take): use a smaller gain, or a shorter sample period",
          text(lambda), h, radius);
  }
}

class LuenbergerModule final : public StructureModule {
 public:
  std::string_view name() const override { return "luenberger"; }

  std::vector<const char*> keys() const override { return {"luenberger"}; }
  void read(const Field& file, Model& m) const override {
    const Field own = file["luenberger"];
    own.allow_only({"state_matrix", "output_matrix", "gain", "input_matrix", "nonlinearity"});
    m.structure = Luenberger{matrix(own["state_matrix"]), matrix(own["output_matrix"]), matrix(own["gain"]),
                             network(own["nonlinearity"]),
                             own.has("input_matrix") ? matrix(own["input_matrix"]) : Eigen::MatrixXd()};
  }
  void write(const Model& m, JsonObject& file) const override {
    const Luenberger& l = own_part<Luenberger>(m);
    JsonObject object(file.inner());
    object.matrix("state_matrix", l.state_matrix);
    object.matrix("output_matrix", l.output_matrix);
    object.matrix("gain", l.gain);
    if (l.input_matrix.size() != 0) object.matrix("input_matrix", l.input_matrix);
    object.network("nonlinearity", l.nonlinearity);
    file.field("luenberger", object.text());
  }
  void check(const Model& m) const override {
    check_no_angles(m);
    check_luenberger(m);
  }

  std::vector<Named<Network>> networks(Model& m) const override {
    return {{"luenberger.nonlinearity", &own_part<Luenberger>(m).nonlinearity, m.nx()}};
  }
  Network* inverse_map(Model&) const override { return nullptr; }
  std::optional<double> fastest_mode(const Model& m) const override {
    return -eigenvalues(error_matrix(own_part<Luenberger>(m))).real().minCoeff();
  }

  std::unique_ptr<ReferenceDynamics<float>> dynamics_in_float(const Model& m, Activations a) const override {
    return std::make_unique<LuenbergerDynamics<float>>(m, a);
  }
  std::unique_ptr<ReferenceDynamics<double>> dynamics_in_double(const Model& m, Activations a) const override {
    return std::make_unique<LuenbergerDynamics<double>>(m, a);
  }

  bool may_diverge() const override { return true; }
  std::unique_ptr<CppStructure> cpp(const ExportSource& source) const override {
    return std::make_unique<LuenbergerHeader>(source);
  }
  Abilities abilities() const override { return {.c99 = true}; }
  std::map<std::string, std::string> c99(const ExportSource& source) const override {
    const Luenberger& own = own_part<Luenberger>(source.model);
    const auto inputs = static_cast<Eigen::Index>(source.model.inputs.size());
    std::map<std::string, std::string> values = c99_of_rk4(source, "c99/luenberger.c.in");
    values["ERROR_MATRIX"] = source.init.matrix(error_matrix(own), "luenberger.state_matrix");
    values["GAIN"] = source.init.matrix(reading_gain(own, inputs), "luenberger.gain");
    return values;
  }
};

}  // namespace

const StructureModule& luenberger_module() {
  static const LuenbergerModule module;
  return module;
}

}  // namespace nlo::codegen
