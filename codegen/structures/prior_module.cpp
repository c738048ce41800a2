// SPDX-License-Identifier: MIT
#include "codegen/model/prior.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "codegen/base/embedded_text.h"
#include "codegen/base/identifier.h"
#include "codegen/model/field_checks.h"
#include "codegen/model/model_fields.h"
#include "codegen/structures/c99_pieces.h"
#include "codegen/structures/equation_text.h"
#include "codegen/structures/linear_latent_fields.h"
#include "codegen/structures/prior_dynamics.h"

namespace nlo::codegen {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Returns n_s, the number of states that the equations step.
int stepped_by(const Model& m) {
  return m.nx() + static_cast<int>(own_part<Prior>(m).equations.unestimated.size());
}

/// Returns the number of entries of w.
Index reads_of_units(const Model& m) {
  return 2 * m.ny() + m.nr() + stepped_by(m);
}

/// Returns the size of [x; p].
int carried_by(const Model& m) {
  return stepped_by(m) + triangle_size(stepped_by(m));
}

int corrections_of(const Model& m) {
  return stepped_by(m) * (m.ny() + 2) + m.ny();
}

/// Returns n_m.
Index units_of(const Model& m) {
  return m.nz() - carried_by(m);
}

class PriorHeader final : public CppStructureBase {
 public:
  explicit PriorHeader(const ExportSource& source)
      : CppStructureBase(source), own_(own_part<Prior>(source.model)), equations_(prior_equations(source.model)) {}

  std::string title() const override {
    return learns() ? "a learned state observer (known equations with learned corrections)"
                    : "a state observer (an extended Kalman filter)";
  }
  std::string description() const override {
    const std::string units = learns() ? fmt::format(", corrected by {} gated units", units_) : "";
    return fmt::format("// Prior: the plant's equations and covariance, stepped by RK4{}. Map T*: {}.\n", units,
                       inverse_map().description()) +
           input_comment();
  }
  std::string header() const override { return "prior_observer.h"; }
  std::vector<CppNetwork> networks() const override {
    if (!learns()) return {inverse_map()};
    return {gates(), candidate(), correction(), inverse_map()};
  }
  std::string declarations() const override {
    const std::string scalar = init_.scalar_name();
    std::string text =
        "/// The plant's known equations: d[x; p]/dt of dx/dt = f(x, u) and its covariance; y = h(x) and "
        "dh/dx.\nstruct Equations {\n";
    if (stepped_ > nx_)
      text += fmt::format("  static constexpr int kStates = {};  ///< the estimated ones, then {}\n", stepped_,
                          fmt::join(own_.equations.unestimated, ", "));
    const auto function = [&](const std::string& head, const std::string& lines) {
      text += "  static constexpr void " + head + " {\n" + lines + "  }\n";
    };
    const EquationLines lines(equations_, init_, "    ", "auto", [&](const std::string& product) {
      return fmt::format("rounded<{}>({})", scalar, product);
    });
    function(fmt::format("derivative(const {0} (&x)[{1}], [[maybe_unused]] const {0}* u, {0} (&dx)[{1}])", scalar,
                         nz_ - units_),
             lines.derivative());
    function(
        fmt::format("output(const {0}* x, {1}{0} (&y)[{2}])", scalar,
                    equations_.outputs_read_inputs() ? fmt::format("const {}* u, ", scalar) : "", ny_ * (1 + stepped_)),
        lines.output());
    return text + "};\n";
  }
  std::string model_type() const override {
    if (!learns())
      return fmt::format("FilterModel<{}, {}, {}, Equations, {}{}>;\n// n_x, n_y, equations, T*{}\n",
                         init_.scalar_name(), nx_, ny_, inverse_map().map_type(init_), input_arguments(),
                         input_words());
    return fmt::format(
        "PriorModel<{}, {}, {}, {}, Equations, {}, {}, {}, {}{}>;\n"
        "// n_x, n_y, n_m, equations, gates, candidate, correction, T*{}\n",
        init_.scalar_name(), nx_, ny_, units_, gates().map_type(init_), candidate().map_type(init_),
        correction().map_type(init_), inverse_map().map_type(init_), input_arguments(), input_words());
  }
  std::string observer() const override { return "PriorObserver"; }
  std::string leading_fields() const override {
    const std::string squashing =
        learns() ? fmt::format("    .fine = {},\n    .coarse = {},\n", init_.vector(own_.fine, "fine"),
                               init_.vector(own_.coarse, "coarse"))
                 : "";
    return fmt::format(
        "    .initial = {},\n    .state_min = {},\n    .state_max = {},\n{}    .state_noise = {},\n"
        "    .output_noise = {},\n",
        init_.vector(m_.initial_latent, "initial_latent"), init_.vector(own_.state_min, "state_min"),
        init_.vector(own_.state_max, "state_max"), squashing, init_.vector(own_.state_noise, "state_noise"),
        init_.vector(own_.output_noise, "output_noise"));
  }

  Index step_multiply_adds() const override {
    constexpr Index kRk4 = 8;  // operations per state: three intermediate slopes, their weighted sum, the step
    const Index equations = kRk4 * (nz_ - units_) + equations_.count(&Expression::operations);
    const Index update =
        ny_ * (stepped_ * stepped_ + 4 * stepped_ + triangle_size(static_cast<int>(stepped_))) + 2 * stepped_;
    if (!learns()) return equations + update;
    return gates().multiply_adds() + candidate().multiply_adds() + correction().multiply_adds() + stepped_ * ny_ +
           equations + update;
  }
  /// Counts squashed innovations and the functions of the equations, too.
  Index step_activations() const override {
    const Index functions = equations_.count(&Expression::functions);
    return learns() ? 3 * units_ + 3 * ny_ + stepped_ + functions : functions;
  }
  /// Counted on filters (bench/embedded): a state or covariance takes up to 200 instructions, mostly for loads and
  /// loops of its Runge-Kutta step and its limits. A sine takes 110, which is 80 more than an activation.
  Index further_instructions() const override {
    return 200 * (nz_ - units_) + 80 * equations_.count(&Expression::functions);
  }
  Index own_scalars() const override {
    return nz_ + 2 * (nz_ - units_) + stepped_ + (learns() ? 3 : 1) * ny_ + 1;  // stale_after
  }

 private:
  bool learns() const { return units_ > 0; }
  std::string units_read() const { return "[m; s(nu); y; u; x-]"; }
  CppNetwork gates() const { return network("gates", "GatesLayer", "GatesNetwork", units_read()); }
  CppNetwork candidate() const { return network("candidate", "CandidateLayer", "CandidateNetwork", units_read()); }
  CppNetwork correction() const { return network("correction", "CorrectionLayer", "CorrectionNetwork", units_read()); }

  const Prior& own_;
  Equations equations_;
  Index stepped_ = equations_.nx();  ///< n_s
  Index units_ = nz_ - equations_.carried();
};

VectorXd largest_carried(const Prior& own) {
  return own.state_min.cwiseAbs().cwiseMax(own.state_max.cwiseAbs());
}

/// Returns the largest magnitude of [m; w].
VectorXd largest_reads(const Model& m, const Prior& own) {
  const Index units = units_of(m);
  VectorXd largest(units + reads_of_units(m));
  largest << VectorXd::Ones(units + 2 * m.ny()), largest_readings(m), largest_carried(own).head(stepped_by(m));
  return largest;
}

void check_unestimated(const Model& m, const EquationTexts& texts) {
  std::vector<std::string> taken;
  for (const auto* channels : {&m.states, &m.inputs})
    for (const Channel& channel : *channels) taken.push_back(channel.name);
  for (std::size_t i = 0; i < texts.unestimated.size(); ++i) {
    const std::string& name = texts.unestimated[i];
    if (!is_identifier(name)) fail("equations.unestimated[{}] is not an identifier", i);
    if (std::ranges::find(taken, name) != taken.end())
      fail("equations.unestimated[{}] is \"{}\", but another state or an input also has this name; rename it", i, name);
    taken.push_back(name);
  }
}

void check_parameters(const EquationTexts& texts) {
  constexpr double kLargest = 1e15;  // the limit of a number in an expression, too
  for (std::size_t i = 0; i < texts.parameters.size(); ++i) {
    const auto& [name, value] = texts.parameters[i];
    if (!is_identifier(name)) fail("equations.parameters[{}] has a name that is not an identifier", i);
    if (!(std::abs(value) < kLargest))
      fail("equations.parameters.{} is {}; it must be below {:g}", name, value, kLargest);
  }
}

/// Checks the gated units and their corrections. A filter without units has none.
void check_units(const Model& m, const Prior& own) {
  const auto units = static_cast<int>(units_of(m));
  if (units == 0) {
    if (own.fine.size() + own.coarse.size() > 0 || !own.gates.layers.empty())
      fail(
          "gates has weights, but latent_min has only the states and their covariance, and no units; give each unit "
          "a latent state, or remove fine, coarse, gates, candidate and correction");
    return;
  }
  for (const auto& [limit, field] : {std::pair{&own.fine, "fine"}, std::pair{&own.coarse, "coarse"}}) {
    check_shape(*limit, m.ny(), field, "n_y");
    check_positive(*limit, field);
  }
  const VectorXd largest = largest_reads(m, own);
  check_gate_layer(own.gates, largest, 2 * units, "gates", "n_u x (n_m + n_w)");
  check_gate_layer(own.candidate, largest, units, "candidate", "n_u x (n_m + n_w)");
  check_gate_layer(own.correction, largest, corrections_of(m), "correction", "n_u x (n_m + n_w)");
  for (Index r = 0; r < units; ++r)
    if (!(std::abs(m.initial_latent(r)) <= 1.0))
      fail("initial_latent[{}] is {}; a gated unit is between -1 and 1", r, m.initial_latent(r));
}

/// Checks the equations over the region that state_min, state_max and the ranges of the inputs describe.
void check_bounded(const Model& m, const Prior& own, const Equations& equations) {
  std::vector<Interval> x, u;
  for (Index i = 0; i < carried_by(m); ++i) x.emplace_back(own.state_min(i), own.state_max(i));
  for (std::size_t j = 0; j < m.inputs.size(); ++j)
    u.emplace_back(m.input_min(static_cast<Index>(j)), m.input_max(static_cast<Index>(j)));
  check_bounded(equations, std::move(x), u, m.sample_period_s);
}

std::vector<std::string> texts(const Field& field) {
  std::vector<std::string> list;
  for (std::size_t i = 0; i < field.array_size(); ++i) list.push_back(text(field[i]));
  return list;
}

std::string json_texts(const std::vector<std::string>& list) {
  std::string all;
  for (const std::string& text : list) all += (all.empty() ? "" : ", ") + json_text(text);
  return "[" + all + "]";
}

class PriorModule final : public StructureModule {
 public:
  std::string_view name() const override { return "prior"; }

  std::vector<const char*> keys() const override {
    return {"equations",    "state_min", "state_max", "fine",       "coarse",     "state_noise",
            "output_noise", "gates",     "candidate", "correction", "inverse_map"};
  }
  void read(const Field& file, Model& m) const override {
    const Field equations = file["equations"], parameters = equations["parameters"];
    equations.allow_only({"derivative", "outputs", "parameters", "unestimated"});
    EquationTexts known{texts(equations["derivative"]), texts(equations["outputs"])};
    parameters.expect(parameters.value.is_object(), "an object of numbers");
    for (const auto& [name, value] : parameters.value.items())
      known.parameters.emplace_back(name, number({value, parameters.path + "." + name}));
    if (equations.has("unestimated")) known.unestimated = texts(equations["unestimated"]);
    Prior own;
    own.equations = std::move(known);
    own.state_min = vector(file["state_min"]);
    own.state_max = vector(file["state_max"]);
    own.state_noise = vector(file["state_noise"]);
    own.output_noise = vector(file["output_noise"]);
    own.inverse_map = network(file["inverse_map"]);
    // A filter without units has none of these; one of them asks for all.
    const auto learned = {"fine", "coarse", "gates", "candidate", "correction"};
    if (std::ranges::any_of(learned, [&file](const char* key) { return file.has(key); })) {
      own.fine = vector(file["fine"]);
      own.coarse = vector(file["coarse"]);
      own.gates = network(file["gates"]);
      own.candidate = network(file["candidate"]);
      own.correction = network(file["correction"]);
    }
    m.structure = std::move(own);
  }
  void write(const Model& m, JsonObject& file) const override {
    const Prior& own = own_part<Prior>(m);
    JsonObject equations(file.inner());
    equations.field("derivative", json_texts(own.equations.derivative));
    equations.field("outputs", json_texts(own.equations.outputs));
    std::string parameters;
    for (const auto& [name, value] : own.equations.parameters)
      parameters += (parameters.empty() ? "" : ", ") + json_text(name) + ": " + literal(value);
    equations.field("parameters", "{" + parameters + "}");
    if (!own.equations.unestimated.empty()) equations.field("unestimated", json_texts(own.equations.unestimated));
    file.field("equations", equations.text());
    file.vector("state_min", own.state_min);
    file.vector("state_max", own.state_max);
    if (units_of(m) > 0) {
      file.vector("fine", own.fine);
      file.vector("coarse", own.coarse);
    }
    file.vector("state_noise", own.state_noise);
    file.vector("output_noise", own.output_noise);
    if (units_of(m) > 0) {
      file.network("gates", own.gates);
      file.network("candidate", own.candidate);
      file.network("correction", own.correction);
    }
    file.network("inverse_map", own.inverse_map);
  }
  void check(const Model& m) const override {
    check_no_angles(m);
    const Prior& own = own_part<Prior>(m);
    const int carried = carried_by(m);
    const auto units = static_cast<int>(units_of(m));
    if (units < 0)
      fail("there are {} latent states; there must be at least {}, for {} states and their covariance", m.nz(), carried,
           stepped_by(m));
    check_parameters(own.equations);
    check_unestimated(m, own.equations);
    const Equations equations = prior_equations(m);
    if (equations.ny() != m.ny())
      fail("equations.outputs has {} expressions, but there are {} outputs; give one for each", equations.ny(), m.ny());
    check_shape(own.state_min, carried, "state_min", "n_s and the covariance");
    check_shape(own.state_max, carried, "state_max", "n_s and the covariance");
    check_range(own.state_min, own.state_max, "state");
    check_shape(own.state_noise, stepped_by(m), "state_noise", "n_s");
    check_positive(own.state_noise, "state_noise");
    check_shape(own.output_noise, m.ny(), "output_noise", "n_y");
    check_positive(own.output_noise, "output_noise");
    check_bounded(m, own, equations);
    check_units(m, own);
    for (Index i = 0; i < carried; ++i)
      if (const double x = m.initial_latent(units + i); !(x >= own.state_min(i) && x <= own.state_max(i)))
        fail("initial_latent[{}] is {}; x starts within state_min and state_max", units + i, x);
    check_network(own.inverse_map, m.nz() + m.nr(), m.nx(), "inverse_map", "n_u x (n_z + n_r)");
    VectorXd read(m.nz() + m.nr());
    read << VectorXd::Ones(units), largest_carried(own), largest_readings(m);
    check_sums(own.inverse_map, read, "inverse_map");
  }

  std::vector<Named<Network>> networks(Model& m) const override {
    Prior& own = own_part<Prior>(m);
    if (units_of(m) == 0) return {{"inverse_map", &own.inverse_map, reads_of(own.inverse_map, m)}};
    const Index all = units_of(m) + reads_of_units(m);
    return {{"gates", &own.gates, all},
            {"candidate", &own.candidate, all},
            {"correction", &own.correction, all},
            {"inverse_map", &own.inverse_map, reads_of(own.inverse_map, m)}};
  }
  Network* inverse_map(Model& m) const override { return &own_part<Prior>(m).inverse_map; }
  bool reads_stalenesses() const override { return true; }
  bool has_known_equations() const override { return true; }
  Index gated_units(const Model& m) const override { return units_of(m); }
  std::optional<VectorXd> latent_limit(const Model& m) const override {
    VectorXd limit(m.nz());
    limit << VectorXd::Ones(units_of(m)), largest_carried(own_part<Prior>(m));
    return limit.cwiseMax(m.initial_latent.cwiseAbs());
  }

  std::unique_ptr<ReferenceDynamics<float>> dynamics_in_float(const Model& m, Activations a) const override {
    return std::make_unique<PriorDynamics<float>>(m, a);
  }
  std::unique_ptr<ReferenceDynamics<double>> dynamics_in_double(const Model& m, Activations a) const override {
    return std::make_unique<PriorDynamics<double>>(m, a);
  }

  std::unique_ptr<CppStructure> cpp(const ExportSource& source) const override {
    return std::make_unique<PriorHeader>(source);
  }
  Abilities abilities() const override { return {.c99 = true}; }
  std::map<std::string, std::string> c99(const ExportSource& source) const override {
    const Prior& own = own_part<Prior>(source.model);
    const Initialiser& init = source.init;
    const Equations equations = prior_equations(source.model);
    const bool more = equations.nx() > source.model.nx();
    const bool learns = units_of(source.model) > 0, decays = learns || !source.model.failures.none();
    const EquationLines lines(equations, init, "  ", "Circle",
                              [](const std::string& product) { return "(" + product + ")"; });
    const std::string derivative = lines.derivative(), output = lines.output();
    std::set<std::string_view> functions = functions_called_in(derivative + output);
    const bool calls_tanh = learns || functions.contains("hyperbolic_tangent");
    if (learns) functions.insert("exponential");
    std::map<std::string, std::string> values = {
        {"LATENT", "c99/prior.c.in"},
        {"BETWEEN", ""},
        {"DECAYS", decays ? "true" : ""},
        {"PHI", decays ? "true" : ""},
        {"TANH", calls_tanh ? "true" : ""},
        {"LONGEST_GAP", std::to_string(kMostPieces)},
        {"FIRST", "    correct(REGULAR_STEP, o->z, o->y, arrived);\n"},
        {"ARRIVALS", "true"},
        {"ARRIVED", ", arrived"},
        {"STEP_DT_COST", fmt::format("{}the equations once for each period",
                                     learns ? "Some 200 operations a unit more than a sample period, and "
                                            : "A step of one sample period, and ")},
        {"MORE_STATES", more ? std::to_string(equations.nx()) : ""},
        {"STEPPED", more ? "kStates" : "kNx"},
        {"UNITS", learns ? std::to_string(units_of(source.model)) : ""},
        {"INPUTS", std::to_string(source.model.inputs.size())},
        {"INPUTS_AND_PART", std::to_string(source.model.inputs.size() + 1)},
        {"DRIVEN", source.model.inputs.empty() ? "" : "true"},
        {"DERIVATIVE", derivative},
        {"OUTPUT", output},
        {"OUTPUT_READS_INPUTS", equations.outputs_read_inputs() ? "true" : ""},
        {"FUNCTIONS", c99_functions(functions, init)},
        {"STATE_MIN", init.vector(own.state_min, "state_min")},
        {"STATE_MAX", init.vector(own.state_max, "state_max")},
        {"FINE", learns ? init.vector(own.fine, "fine") : ""},
        {"COARSE", learns ? init.vector(own.coarse, "coarse") : ""},
        {"STATE_NOISE", init.vector(own.state_noise, "state_noise")},
        {"OUTPUT_NOISE", init.vector(own.output_noise, "output_noise")},
        {"LEAST_NOISE", init(1.0 + static_cast<double>(kLeastNoise), "the least noise")},
        {"SIXTH", init(1.0 / 6, "a sixth")},
        {"THIRD", init(1.0 / 3, "a third")}};
    if (!learns)  // log_1_plus alone
      values["GATE"] = functions.contains("logarithm")
                           ? filled(embedded_text("c99/gate.c.in"),
                                    {{"F", init.scalar_bytes() == 4 ? "f" : ""}, {"GATES", ""}, {"IN_SCALAR", ""}})
                           : "";
    return values;
  }
};

}  // namespace

const StructureModule& prior_module() {
  static const PriorModule module;
  return module;
}

}  // namespace nlo::codegen
