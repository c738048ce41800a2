// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cmath>

#include "codegen/model/domain.h"
#include "codegen/model/latent_step.h"
#include "codegen/model/model_fields.h"
#include "codegen/reference/linear_steps.h"
#include "codegen/structures/linear_latent_fields.h"

namespace nlo::codegen {
namespace {

template <class Scalar>
class KklDynamics final : public ReferenceDynamics<Scalar> {
 public:
  using typename ReferenceDynamics<Scalar>::Vector;
  using typename ReferenceDynamics<Scalar>::Matrix;

  explicit KklDynamics(const Model& m) : latent_(m) {}

  void start(Matrix& z, const Matrix& y, const std::vector<bool>*) const override { latent_.start(z, y); }
  void advance(Vector& z, const Between<Scalar>& over, double dt_s) override { latent_.advance(z, over, dt_s); }
  Matrix slope(const Matrix& z, const Matrix& y, const Vector&) const override { return latent_.slope(z, y); }

 private:
  LinearSteps<Scalar> latent_;
};

std::string c99_tables(const Model& m, const FoldedModel& folded, const Initialiser& init) {
  const LinearLatent& latent = *linear_latent(m);
  const char* r = m.nr() == m.ny() ? "kNy" : "kNr";  // the name in the template
  const auto vector = [&](const char* name, const char* size, const Eigen::VectorXd& values, const char* field) {
    return fmt::format("static const IN_FLASH Scalar {}[{}] = {};\n", name, size, init.vector(values, field));
  };
  const auto matrix = [&](const char* name, const Eigen::MatrixXd& values, const char* field) {
    return fmt::format("static const IN_FLASH Scalar {}[kNz][{}] = {};\n", name, r, init.matrix(values, field));
  };
  return "// D [1/s], F and the steady state S y of a constant y.\n" +
         vector("kEigenvalues", "kNz", latent.eigenvalues, "eigenvalues") +
         matrix("kOutputInjection", latent.output_injection, "output_injection") +
         matrix("kSteadyGain", folded.steady_gain, "steady_gain") +
         (!m.saturates()
              ? ""
              : "// Limits of the z that T* reads.\n" + vector("kReachMin", "kNz", LatentReach(m).min, "saturation") +
                    vector("kReachMax", "kNz", LatentReach(m).max, "saturation"));
}

class KklModule final : public StructureModule {
 public:
  std::string_view name() const override { return "kkl"; }

  std::vector<const char*> keys() const override {
    return {"starts_steady", "relative_outputs", "pairs", "eigenvalues", "output_injection", "inverse_map"};
  }
  void read(const Field& file, Model& m) const override {
    Kkl& own = m.structure.emplace<Kkl>();
    read_linear_latent(file, own.latent);
    own.inverse_map = network(file["inverse_map"]);
  }
  void write(const Model& m, JsonObject& file) const override {
    const Kkl& own = own_part<Kkl>(m);
    write_linear_latent(own.latent, file);
    file.network("inverse_map", own.inverse_map);
  }
  void check(const Model& m) const override {
    check_linear_latent(m);
    check_latent_map(m);
  }

  std::vector<Named<Network>> networks(Model& m) const override {
    Network& map = own_part<Kkl>(m).inverse_map;
    return {{"inverse_map", &map, reads_of(map, m)}};
  }
  Network* inverse_map(Model& m) const override { return &own_part<Kkl>(m).inverse_map; }
  LinearLatent* linear_latent(Model& m) const override { return &own_part<Kkl>(m).latent; }
  std::optional<double> fastest_mode(const Model& m) const override {
    return fastest_driven_mode(own_part<Kkl>(m).latent);
  }
  std::optional<double> slowest_mode(const Model& m) const override {
    return slowest_driven_mode(own_part<Kkl>(m).latent);
  }

  std::unique_ptr<ReferenceDynamics<float>> dynamics_in_float(const Model& m, Activations) const override {
    return std::make_unique<KklDynamics<float>>(m);
  }
  std::unique_ptr<ReferenceDynamics<double>> dynamics_in_double(const Model& m, Activations) const override {
    return std::make_unique<KklDynamics<double>>(m);
  }

  bool computes_outputs() const override { return true; }
  bool reads_stalenesses() const override { return true; }
  bool saturates() const override { return true; }
  bool multiplies_by_clocks() const override { return true; }

  Abilities abilities() const override { return {.c99 = true, .int16 = true}; }
  std::unique_ptr<CppStructure> cpp(const ExportSource& source) const override {
    return std::make_unique<KklHeader>(source);
  }
  std::map<std::string, std::string> c99(const ExportSource& source) const override {
    return c99_of_linear_latent(source);
  }
};

}  // namespace

std::map<std::string, std::string> c99_of_linear_latent(const ExportSource& source) {
  const LinearLatent& latent = *linear_latent(source.model);
  const StepMatrices& step = source.folded.step;
  return {{"LATENT", "c99/kkl.c.in"},
          {"STEP_DT_COST", "Some 60 operations per latent state"},
          {"LINEAR_STEP", "Step"},
          {"STEP_TABLE", "true"},
          {"MAKE_LINEAR", "make_step"},
          {"ADVANCE_LINEAR", "advance"},
          {"COMPLEX", latent.pairs > 0 ? "true" : ""},
          {"WARM_START", "c99/warm_start.h.in"},
          {"WARM_START_BODY", "c99/warm_start.c.in"},
          {"PAIRS", std::to_string(latent.pairs)},
          {"FIRST_ORDER", source.model.hold == Hold::kZeroOrder ? "" : "true"},
          {"FIRST", latent.starts_steady ? "    settle(o);\n" : ""},
          {"A_MINUS_1", source.init.vector(step.a_minus_1, "A")},
          {"B0", source.init.matrix(step.b0, "B0")},
          {"B1", source.init.matrix(step.b1, "B1")},
          {"TABLES", c99_tables(source.model, source.folded, source.init)}};
}

const StructureModule& kkl_module() {
  static const KklModule module;
  return module;
}

}  // namespace nlo::codegen
