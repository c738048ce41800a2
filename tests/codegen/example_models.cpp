// SPDX-License-Identifier: MIT
#include "tests/codegen/example_models.h"
#include "codegen/model/activations.h"
#include "codegen/model/hold.h"
#include "tests/codegen/flown.h"

#include <Eigen/LU>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

namespace nlo::codegen {
namespace {

/// splitmix64: the same weights on every platform. Source: Steele, Lea, Flood 2014.
class Uniform {
 public:
  explicit Uniform(std::uint64_t seed) : state_(seed) {}

  double operator()(double half_width) {
    std::uint64_t bits = state_ += 0x9e3779b97f4a7c15U;
    bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9U;
    bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebU;
    bits ^= bits >> 31;
    return half_width * (static_cast<double>(bits >> 11) * 0x1p-52 - 1.0);
  }

  Eigen::MatrixXd matrix(Eigen::Index rows, Eigen::Index cols, double half_width) {
    Eigen::MatrixXd values(rows, cols);
    for (Eigen::Index i = 0; i < rows; ++i)
      for (Eigen::Index j = 0; j < cols; ++j) values(i, j) = (*this)(half_width);
    return values;
  }

 private:
  std::uint64_t state_;
};

/// Random layers of the given widths (the first is n_u), with weights as large as at the start of training.
std::vector<DenseLayer> random_layers(const std::vector<int>& widths, std::uint64_t seed) {
  Uniform uniform(seed);
  std::vector<DenseLayer> layers;
  for (std::size_t l = 0; l + 1 < widths.size(); ++l) {
    const double half_width = std::sqrt(3.0 / widths[l]);
    DenseLayer layer;
    layer.weights = uniform.matrix(widths[l + 1], widths[l], half_width);
    layer.bias = uniform.matrix(widths[l + 1], 1, 0.5);
    layers.push_back(layer);
  }
  return layers;
}

/// A network of the given widths, with random scales and means; `scale` multiplies its outputs.
Network random_network(const std::vector<int>& widths, std::uint64_t seed, double scale) {
  Network n;
  n.layers = random_layers(widths, seed);
  n.features = Eigen::MatrixXd::Identity(widths.front(), widths.front());
  n.feature_mean = Eigen::VectorXd::LinSpaced(widths.front(), -0.1, 0.1);
  n.feature_scale = Eigen::VectorXd::LinSpaced(widths.front(), 0.8, 1.3);
  n.output_mean = Eigen::VectorXd::LinSpaced(widths.back(), -0.05, 0.1);
  n.output_scale = Eigen::VectorXd::Constant(widths.back(), scale);
  return n;
}

/// Returns a model that has only channels, their ranges and a sample period.
Model blank(const std::string& name, int ny, int nx) {
  Model m;
  m.name = name;
  for (int j = 0; j < ny; ++j) m.outputs.push_back({"y" + std::to_string(j + 1), "rad", 0.0});
  for (int i = 0; i < nx; ++i) m.states.push_back({"x" + std::to_string(i + 1), "", 0.0});
  m.sample_period_s = 0.02;
  m.output_min = Eigen::VectorXd::Constant(ny, -3.0);
  m.output_max = Eigen::VectorXd::Constant(ny, 3.0);
  m.provenance = {{"plant", name}, {"seed", "3"}};
  return m;
}

/// Sets latent ranges to the size of initial_latent.
Model with_domain(Model m) {
  m.latent_min = Eigen::VectorXd::Constant(m.nz(), -8.0);
  m.latent_max = Eigen::VectorXd::Constant(m.nz(), 8.0);
  return m;
}

/// One output "y", real eigenvalues, F = ones; T* reads only z.
Model model_with(const std::string& name, const Eigen::VectorXd& eigenvalues, const std::vector<Channel>& states,
                 const std::vector<int>& hidden) {
  Model m;
  m.name = name;
  m.outputs = {{"y", "m", 0.0}};
  m.states = states;
  m.sample_period_s = 0.02;
  linear_latent(m)->eigenvalues = eigenvalues;
  const Eigen::Index nz = eigenvalues.size();
  linear_latent(m)->output_injection = Eigen::MatrixXd::Ones(nz, 1);
  m.initial_latent = Eigen::VectorXd::Zero(nz);
  m.output_min = Eigen::VectorXd::Constant(1, -3.0);
  m.output_max = Eigen::VectorXd::Constant(1, 3.0);
  m.latent_max = -4.0 * eigenvalues.cwiseInverse();
  m.latent_min = -m.latent_max;
  Network& map = *inverse_map(m);
  map.features = Eigen::MatrixXd::Identity(nz, nz + 1);
  map.feature_mean = Eigen::VectorXd::LinSpaced(nz, -0.1, 0.1);
  map.feature_scale = -0.7 * eigenvalues.cwiseInverse();

  std::vector<int> widths = {static_cast<int>(nz)};
  widths.insert(widths.end(), hidden.begin(), hidden.end());
  widths.push_back(m.nx());
  map.layers = random_layers(widths, 1);
  map.output_mean = Eigen::VectorXd::LinSpaced(m.nx(), 0.05, 0.25);
  map.output_scale = Eigen::VectorXd::LinSpaced(m.nx(), 1.4, 1.9);
  m.provenance = {{"plant", "Van der Pol"}, {"seed", "1"}, {"norm N(0, 0.5)", "0.17"}};
  return m;
}

}  // namespace

Model paper_model() {
  return model_with("van_der_pol", Eigen::Vector3d(-0.81, -0.83, -0.63), {{"x1", "m", 0.0}, {"x2", "m/s", 0.0}},
                    {50, 50, 50, 50});
}

Model large_model() {
  return model_with("large", Eigen::Vector3d(-0.81, -0.83, -0.63), {{"x1", "m", 0.0}, {"x2", "m/s", 0.0}},
                    {256, 256, 256});
}

Model mixed_model() {
  return model_with("mixed", Eigen::Vector3d(-0.81, -0.83, -0.63), {{"x1", "m", 0.0}, {"x2", "m/s", 0.0}},
                    {18, 300, 60});
}

Model tiny_model() {
  return model_with("tiny", Eigen::Vector2d(-1.0, -4.0), {{"position", "m", 0.0}}, {4});
}

Model linear_model() {
  return model_with("linear", Eigen::Vector2d(-1.0, -4.0), {{"position", "m", 0.0}, {"speed", "m/s", 0.0}}, {});
}

Model activation_model(const std::string& activation) {
  Model m = model_with("tiny_" + activation, Eigen::Vector2d(-2.0, -9.0), {{"x1", "", 0.0}, {"x2", "", 0.0}}, {16, 16});
  inverse_map(m)->activation = activation_named(activation).kind;
  return m;
}

Model hold_model(const std::string& hold) {
  Model m = tiny_model();
  m.name += "_" + hold;
  m.hold = *find_hold(hold);
  return m;
}

Model rig_model() {
  Model m;
  m.name = "rig";
  m.outputs = {{"alpha", "rad", 2.0 * std::numbers::pi}, {"load", "N", 0.0}};
  m.states = {{"alpha_dot", "rad/s", 0.0}, {"load_dot", "N/s", 0.0}, {"phase", "rad", 2.0 * std::numbers::pi}};
  m.sample_period_s = 0.004;
  linear_latent(m)->pairs = 2;
  linear_latent(m)->eigenvalues.resize(7);
  linear_latent(m)->eigenvalues << -40.0, 30.0, -25.0, 35.0, -60.0, -15.0, -2.0;  // pair, pair, real, real, clock

  // F = -D in the column of each output, so both modes settle at z = y.
  linear_latent(m)->output_injection = Eigen::MatrixXd::Zero(7, 2);
  linear_latent(m)->output_injection.col(0) << 40.0, -30.0, 0.0, 0.0, 60.0, 0.0, 0.0;
  linear_latent(m)->output_injection.col(1) << 0.0, 0.0, 25.0, -35.0, 0.0, 15.0, 0.0;
  m.initial_latent = Eigen::VectorXd::Unit(7, 6);
  linear_latent(m)->starts_steady = true;
  m.output_min = Eigen::Vector2d(-std::numbers::pi, -5.0);
  m.output_max = Eigen::Vector2d(std::numbers::pi, 5.0);
  m.latent_max = Eigen::VectorXd::Constant(7, 6.0);
  m.latent_min = Eigen::VectorXd::Constant(7, -6.0);
  linear_latent(m)->relative_outputs = {1};  // the load: z - y has a narrower range than z
  for (const int row : {2, 3, 5}) {
    m.latent_max(row) = 1.0;
    m.latent_min(row) = -1.0;
  }

  // Reads z - y in the rows that settle at an output, z in the others, and the load itself.
  Network& map = *inverse_map(m);
  map.features = Eigen::MatrixXd::Zero(8, 9);
  map.features.leftCols(7).topRows(7).setIdentity();
  for (const int row : {0, 4}) map.features(row, 7) = -1.0;
  for (const int row : {2, 5}) map.features(row, 8) = -1.0;
  map.features(7, 8) = 1.0;
  map.feature_mean = Eigen::VectorXd::LinSpaced(8, -0.05, 0.05);
  map.feature_scale = Eigen::VectorXd::LinSpaced(8, 0.2, 1.1);
  map.layers = random_layers({8, 32, 24, 3}, 7);
  map.skip = Uniform(8).matrix(3, 8, 0.4);
  map.output_mean = Eigen::Vector3d(0.0, 0.3, -0.1);
  map.output_scale = Eigen::Vector3d(8.0, 20.0, 1.0);
  m.provenance = {{"plant", "logs of a rig"}, {"seed", "2"}};
  return m;
}

namespace {

/// Adds a monitor whose limits and predictions some samples of a run exceed.
Model with_monitor(Model m) {
  const Eigen::Index ny = m.ny(), nz = m.nz(), windows = 2;
  Monitor monitor;
  monitor.prediction = Uniform(41).matrix(ny, nz + m.nr() + m.nx(), 0.05);
  monitor.offset = Eigen::VectorXd::Constant(ny, 0.01);
  monitor.deviation = Eigen::VectorXd::LinSpaced(ny, 0.2, 0.3);
  monitor.least_variance = Eigen::VectorXd::Constant(ny, 0.5);
  monitor.latent_mean = Uniform(42).matrix(nz, 1, 0.1);
  monitor.latent_deviation = 0.25 * (m.latent_max - m.latent_min);
  monitor.windows_s = Eigen::Vector2d(5.0, 20.0) * m.sample_period_s;
  monitor.mean_limit = Eigen::MatrixXd::Constant(ny, windows, 0.5);
  monitor.variance_limit = Eigen::MatrixXd::Constant(ny, windows, 4.0);
  monitor.correlation_limit = Eigen::MatrixXd::Constant(ny, windows, 2.0);
  monitor.latent_limit = Eigen::Vector2d(3.0, 2.0);
  monitor.missing_limit = Eigen::VectorXd::Constant(ny, 0.4);
  monitor.gate = 4.0;
  monitor.most_equal = Eigen::VectorXd::Constant(ny, 30.0);
  monitor.resting = monitor.reference_sensor = Eigen::VectorXd::Zero(ny);
  monitor.rest_min = Eigen::VectorXd::Constant(ny, -0.25);
  monitor.rest_max = Eigen::VectorXd::Constant(ny, 0.5);
  monitor.most_moved = Eigen::VectorXd::Constant(ny, 50.0);
  monitor.motion = Eigen::VectorXd::Constant(ny, 0.1);
  monitor.row = Uniform(43).matrix(m.nx(), nz + m.nr(), 0.05);
  monitor.row_offset = Eigen::VectorXd::Constant(m.nx(), 0.01);
  monitor.row_deviation = Eigen::VectorXd::Constant(m.nx(), 0.5);
  monitor.disagreement_limit = Eigen::VectorXd::Constant(m.nx(), 3.0);
  monitor.armed_after_s = 10.0 * m.sample_period_s;
  monitor.false_alarms_per_hour = 1.0;
  monitor.hours = 12.0;
  m.monitor = monitor;
  return m;
}

}  // namespace

Model watched_model() {
  Model m = with_monitor(tiny_model());
  m.name = "watched";
  return m;
}

Model watched_rig_model() {
  Model m = with_monitor(rig_model());
  m.monitor->replaces = Eigen::VectorXd::Ones(m.ny());
  m.name = "watched_rig";
  return m;
}

Model watched_computed_model() {
  Model m = with_monitor(computed_model());
  m.name = "watched_computed";
  return m;
}

Model luenberger_model() {
  Model m = blank("pendulum", 1, 2);
  m.initial_latent = Eigen::Vector2d(0.1, -0.2);
  Luenberger l;
  l.state_matrix = (Eigen::Matrix2d() << 0.0, 1.0, -4.0, -0.3).finished();
  l.output_matrix = Eigen::RowVector2d(1.0, 0.0);
  l.gain = Eigen::Vector2d(3.0, 2.0);
  l.nonlinearity = random_network({2, 8, 2}, 11, 0.4);
  m.structure = l;
  return with_domain(m);
}

Model general_model() {
  Model m = blank("general", 2, 2);
  m.initial_latent = Eigen::Vector3d(0.1, 0.0, -0.1);
  Network f = random_network({5, 12, 3}, 21, 0.3);
  f.skip = Eigen::MatrixXd::Zero(3, 5);
  f.skip.leftCols(3) << -2.0, 3.0, 0.0, -3.0, -2.0, 0.0, 0.0, 0.4, -5.0;
  f.skip.rightCols(2) = Uniform(22).matrix(3, 2, 2.0);
  f.output_scale.setOnes();
  f.feature_scale.setOnes();
  m.structure = General{f, random_network({3, 8, 2}, 23, 1.2)};
  return with_domain(m);
}

Model gated_model() {
  Model m = blank("gated", 2, 2);
  m.initial_latent = Eigen::VectorXd::Zero(5);
  m.initial_latent(1) = -0.3;
  Network gates = random_network({7, 10}, 51, 0.8), candidate = random_network({7, 5}, 52, 0.9);
  gates.output_scale.setOnes();
  gates.layers[0].bias.head(5) << -3.0, -2.0, -1.0, 0.0, 1.0;
  m.structure = Gated{gates, candidate, random_network({7, 8, 2}, 53, 1.2)};
  return with_domain(m);
}

Model contracting_gated_model() {
  Model m = gated_model();
  m.name = "contracting_gated";
  Gated& own = std::get<Gated>(m.structure);
  // Small weights on z, so that the proof succeeds.
  own.gates.layers[0].weights.leftCols(5) *= 0.02;
  own.candidate.layers[0].weights.leftCols(5) *= 0.1;
  own.contraction = find_contraction(m, own);
  return m;
}

Model driven_model() {
  Model m = blank("driven", 1, 2);
  m.initial_latent = Eigen::Vector3d::Zero();
  DrivenKkl& drive = m.structure.emplace<DrivenKkl>();
  linear_latent(m)->pairs = 1;
  linear_latent(m)->eigenvalues = Eigen::Vector3d(-2.0, 3.0, -6.0);
  linear_latent(m)->output_injection = Eigen::Vector3d(2.0, -3.0, 6.0);
  linear_latent(m)->starts_steady = true;
  *inverse_map(m) = random_network({4, 12, 2}, 31, 0.8);
  inverse_map(m)->features = Eigen::MatrixXd::Identity(4, 4);
  inverse_map(m)->skip = Uniform(32).matrix(2, 4, 0.5);
  drive.inputs = {{"torque", "N m", 0.0}, {"wind", "", 0.0}};
  drive.input_hold = Hold::kFirstOrder;
  drive.input_field = {Uniform(33).matrix(4, 2, 0.4), Uniform(34).matrix(4, 1, 1.0)};
  drive.forward_map = random_network({2, 12, 3}, 35, 0.7);
  drive.forward_map.skip = Uniform(36).matrix(3, 2, 0.5);
  return with_domain(m);
}

namespace {

/// Adds one input with the range +-2 and this hold.
Model with_input(Model m, const std::string& name, Hold hold) {
  m.name = name;
  m.inputs = {{"torque", "N m", 0.0}};
  m.input_hold = hold;
  m.input_min = Eigen::VectorXd::Constant(1, -2.0);
  m.input_max = Eigen::VectorXd::Constant(1, 2.0);
  return m;
}

}  // namespace

Model commanded_model() {
  Model m = blank("commanded", 1, 2);
  m.inputs = {{"voltage", "V", 0.0}, {"brake", "", 0.0}};
  m.input_min = Eigen::Vector2d(-12.0, 0.0);
  m.input_max = Eigen::Vector2d(12.0, 1.0);
  linear_latent(m)->pairs = 1;
  linear_latent(m)->eigenvalues.resize(5);
  linear_latent(m)->eigenvalues << -3.0, 4.0, -5.0, -7.0, -0.5;  // pair of y, real of each reading, clock
  linear_latent(m)->output_injection = Eigen::MatrixXd::Zero(5, 3);
  linear_latent(m)->output_injection.col(0) << 3.0, -4.0, 0.0, 0.0, 0.0;
  linear_latent(m)->output_injection.col(1) << 0.0, 0.0, 5.0, 0.0, 0.0;
  linear_latent(m)->output_injection.col(2) << 0.0, 0.0, 0.0, 7.0, 0.0;
  linear_latent(m)->starts_steady = true;
  linear_latent(m)->relative_outputs = {0};
  m.initial_latent = Eigen::VectorXd::Unit(5, 4);
  m.latent_max = Eigen::VectorXd::Constant(5, 4.0);
  m.latent_max(2) = 14.0;
  m.latent_min = -m.latent_max;
  Network& map = *inverse_map(m);
  map = random_network({7, 16, 12, 2}, 51, 1.1);
  map.features = Eigen::MatrixXd::Zero(7, 8);
  map.features.leftCols(5).topRows(5).setIdentity();
  map.features(0, 5) = -1.0;  // reads z - y
  map.features(5, 6) = map.features(6, 7) = 1.0;
  map.feature_scale << 1.0, 1.0, 6.0, 0.6, 0.5, 6.0, 0.6;
  map.skip = Uniform(52).matrix(2, 7, 0.3);
  return m;
}

namespace {

/// T* also reads each feature except the clock, multiplied by the clock, which is the last row of z.
Model with_clock_products(Model m) {
  Network& map = *inverse_map(m);
  const Eigen::Index plain = map.features.rows(), clock = m.nz() - 1;
  map.feature_clocks.assign(static_cast<std::size_t>(plain), -1);
  for (Eigen::Index f = 0; f < plain; ++f) {
    if (map.features(f, clock) != 0.0) continue;
    const Eigen::Index row = map.features.rows();
    map.features.conservativeResize(row + 1, Eigen::NoChange);
    map.features.row(row) = map.features.row(f);
    for (Eigen::VectorXd* of : {&map.feature_mean, &map.feature_scale}) {
      of->conservativeResize(row + 1);
      (*of)(row) = (*of)(f);
    }
    map.feature_clocks.push_back(static_cast<int>(clock));
  }
  const auto columns = map.features.rows();
  Uniform uniform(71);
  Eigen::MatrixXd& first = map.layers.front().weights;
  first.conservativeResize(Eigen::NoChange, columns);
  first.rightCols(columns - plain) = uniform.matrix(first.rows(), columns - plain, 0.4);
  map.skip.conservativeResize(Eigen::NoChange, columns);
  map.skip.rightCols(columns - plain) = uniform.matrix(map.skip.rows(), columns - plain, 0.3);
  return m;
}

}  // namespace

Model clocked_model() {
  Model m = with_clock_products(commanded_model());
  m.name = "clocked";
  return m;
}

Model clocked_rig_model() {
  Model m = with_clock_products(rig_model());
  m.name = "clocked_rig";
  return m;
}

Model fallback_model() {
  Model m = clocked_model();
  m.name = "fallback";
  Network& map = *inverse_map(m);
  Uniform uniform(73);
  map.fallback = {{1},
                  uniform.matrix(1, map.features.rows(), 0.3),
                  Eigen::VectorXd::Constant(1, 0.2),
                  Eigen::VectorXd::Constant(1, 0.7)};
  return m;
}

void fall_back(const Fallback& fallback, const Eigen::VectorXd& in, Eigen::VectorXd& out) {
  for (std::size_t f = 0; f < fallback.outputs.size(); ++f) {
    const auto at = static_cast<Eigen::Index>(f);
    const double row = fallback.rows.row(at).dot(in) + fallback.offset(at);
    double& estimate = out(fallback.outputs[f]);
    const double ratio = (estimate - row) / fallback.reach(at);
    estimate = row + (estimate - row) / (1.0 + ratio * ratio);
  }
}

Model encoder_model() {
  Model m = blank("encoder", 1, 3);
  m.outputs = {{"encoder", "rad", 0.0}};
  m.states = {{"omega", "rad/s", 0.0}, {"current", "A", 0.0}, {"load", "N m", 0.0}};
  m.inputs = {{"voltage", "V", 0.0}};
  m.input_min = Eigen::VectorXd::Constant(1, -24.0);
  m.input_max = Eigen::VectorXd::Constant(1, 24.0);
  m.sample_period_s = 1e-3;
  m.output_min(0) = -1000.0;
  m.output_max(0) = 1000.0;
  // R = 1 Ohm, L = 2 mH, k = 40 mN m/A, J = 1e-4 kg m^2, b = 1e-5 N m s
  Eigen::Matrix4d a;
  a << 0, 1, 0, 0, 0, -0.1, 400, -1e4, 0, -20, -500, 0, 0, 0, 0, 0;
  const Eigen::Vector4d b(0, 0, 500, 0);
  const Eigen::Vector3d rates(60.0, 90.0, 140.0);
  LinearLatent& latent = *linear_latent(m);
  latent.eigenvalues = -rates;
  latent.output_injection.resize(3, 2);
  Eigen::Matrix<double, 3, 4> t;
  for (int r = 0; r < 3; ++r) {  // T A = D T + F C
    const Eigen::Matrix4d shifted = a + rates(r) * Eigen::Matrix4d::Identity();
    t.row(r) = rates(r) * Eigen::RowVector4d::Unit(0) * shifted.inverse();
    latent.output_injection.row(r) << rates(r), t.row(r) * b;
  }
  latent.starts_steady = true;
  latent.relative_outputs = {0};
  m.initial_latent = Eigen::Vector3d::Zero();
  m.latent_max = t.rightCols<3>().cwiseAbs() * Eigen::Vector3d(400.0, 30.0, 0.5);
  m.latent_min = -m.latent_max;
  Network map;
  map.features = Eigen::MatrixXd::Zero(3, 5);
  map.features.leftCols(3).setIdentity();
  map.features.col(3).setConstant(-1.0);  // z - y
  map.feature_mean = map.output_mean = Eigen::Vector3d::Zero();
  map.feature_scale = m.latent_max;
  map.output_scale = Eigen::Vector3d::Ones();
  map.layers = {{t.rightCols<3>().inverse() * m.latent_max.asDiagonal(), Eigen::Vector3d::Zero()}};
  *inverse_map(m) = map;
  return m;
}

Model commanded_ramp_model() {
  Model m = commanded_model();
  m.name = "commanded_ramp";
  m.input_hold = Hold::kFirstOrder;
  return m;
}

Model failing_model() {
  Model m = commanded_model();
  m.name = "failing";
  m.outputs.push_back({"y2", "m", 0.0});
  m.output_min = Eigen::Vector2d(-3.0, -1.0);
  m.output_max = Eigen::Vector2d(3.0, 5.0);
  m.failures = {.outputs = {1}, .rest = Eigen::VectorXd::Constant(1, 1.5), .staleness_s = 0.1};
  LinearLatent& latent = *linear_latent(m);
  const Eigen::MatrixXd before = latent.output_injection;  // y, voltage, brake
  latent.output_injection = Eigen::MatrixXd::Zero(5, 5);   // y, y2, voltage, brake, staleness
  latent.output_injection.col(0) = before.col(0);
  latent.output_injection.col(2) = before.col(1);
  latent.output_injection(3, 1) = 7.0;  // y2 uses the mode of the brake
  m.latent_max(3) = 8.0;
  m.latent_min(3) = -4.0;
  Network& map = *inverse_map(m);
  map = random_network({9, 16, 12, 2}, 53, 1.1);
  map.features = Eigen::MatrixXd::Zero(9, 10);
  map.features.leftCols(5).topRows(5).setIdentity();
  map.features(0, 5) = -1.0;  // reads z - y
  for (int i = 0; i < 4; ++i) map.features(5 + i, 6 + i) = 1.0;
  map.feature_scale << 1.0, 1.0, 6.0, 2.0, 0.5, 2.0, 6.0, 0.6, 0.5;
  return m;
}

Model failing_rig_model() {
  Model m = rig_model();
  m.name = "failing_rig";
  m.failures = {.outputs = {1}, .rest = Eigen::VectorXd::Constant(1, -0.5), .staleness_s = 0.05};
  LinearLatent& latent = *linear_latent(m);
  latent.output_injection.conservativeResize(7, 3);
  latent.output_injection.col(2).setZero();
  Network& map = *inverse_map(m);
  map.features.conservativeResize(8, 10);
  map.features.col(9).setZero();
  map.features(6, 9) = 0.7;  // next to the clock
  return m;
}

Model two_rates_model() {
  Model m = rig_model();
  m.name = "two_rates";
  m.outputs[1].period_s = 5.0 * m.sample_period_s;
  return m;
}

Model watched_two_rates_model() {
  Model m = with_monitor(two_rates_model());
  m.monitor->replaces = Eigen::Vector2d(1.0, 0.0);  // a slow output is not replaced
  m.name = "watched_two_rates";
  return m;
}

Model failing_two_rates_model() {
  Model m = failing_rig_model();
  m.name = "failing_two_rates";
  m.outputs[1].period_s = 5.0 * m.sample_period_s;
  return m;
}

Model watched_failing_two_rates_model() {
  Model m = failing_model();
  m.outputs[1].period_s = 4.0 * m.sample_period_s;
  m = with_monitor(m);
  m.name = "watched_failing_two_rates";
  return m;
}

Model slow_angle_model() {
  Model m = rig_model();
  m.name = "slow_angle";
  m.outputs[0].period_s = 3.0 * m.sample_period_s;
  return m;
}

Model computed_model() {
  Model m = failing_model();
  m.name = "computed";
  m.outputs.push_back({"power", "W", 0.0, "0.5 * y1 * voltage"});
  m.outputs.push_back({"drag", "", 0.0, "y2^2 - (y1 - 2) * brake / 4"});  // computed from outputs that may be missing
  m.output_min = Eigen::Vector4d(-3.0, -1.0, -18.0, -1.0);
  m.output_max = Eigen::Vector4d(3.0, 5.0, 18.0, 26.0);
  m.failures = {.outputs = {1, 3}, .rest = Eigen::Vector2d(1.5, 2.0), .staleness_s = 0.1};
  LinearLatent& latent = *linear_latent(m);
  const Eigen::MatrixXd before = latent.output_injection;  // y1, y2, voltage, brake, staleness
  latent.output_injection = Eigen::MatrixXd::Zero(5, 8);   // y1, y2, power, drag, voltage, brake, stalenesses
  latent.output_injection.col(0) = before.col(0);
  latent.output_injection.col(3) = 0.2 * before.col(1);  // drag uses the mode of y2
  latent.output_injection(2, 2) = 5.0;                   // power uses the mode of the voltage
  m.latent_max(2) = 20.0;
  m.latent_min(2) = -20.0;
  Network& map = *inverse_map(m);
  map = random_network({12, 16, 12, 2}, 59, 1.1);
  map.features = Eigen::MatrixXd::Zero(12, 13);
  map.features.leftCols(5).topRows(5).setIdentity();
  map.features(0, 5) = -1.0;  // reads z - y1
  for (int i = 0; i < 7; ++i) map.features(5 + i, 6 + i) = 1.0;
  map.feature_scale << 1.0, 1.0, 9.0, 2.0, 0.5, 2.0, 9.0, 9.0, 6.0, 0.6, 0.5, 0.5;
  return m;
}

Model computed_gated_model() {
  Model m = gated_model();
  m.name = "computed_gated";
  const std::string a = m.outputs[0].name, b = m.outputs[1].name;
  m.outputs.push_back({"product", "", 0.0, a + " * " + b});
  m.output_min.conservativeResize(3);
  m.output_max.conservativeResize(3);
  m.output_min(2) = -30.0;
  m.output_max(2) = 30.0;
  Network map = std::get<Gated>(m.structure).inverse_map;
  map.features.conservativeResize(7, 8);
  map.features.col(7).setZero();
  map.features(6, 7) = 0.1;
  m.structure = Gated{random_network({8, 10}, 61, 0.8), random_network({8, 5}, 62, 0.9), map};
  return m;
}

Model saturating_model() {
  Model m = failing_model();
  m.name = "saturating";
  m.saturation = 0.5;
  linear_latent(m)->relative_outputs = {};
  m.latent_min *= 0.2;  // small, so that the replay leaves it
  m.latent_max *= 0.2;
  return m;
}

Model saturating_rig_model() {
  Model m = rig_model();
  m.name = "saturating_rig";
  m.saturation = 0.25;
  m.latent_min *= 0.3;
  m.latent_max *= 0.3;
  return m;
}

Model commanded_luenberger_model() {
  Model m = with_input(luenberger_model(), "commanded_pendulum", Hold::kZeroOrder);
  std::get<Luenberger>(m.structure).input_matrix = Eigen::Vector2d(0.0, 1.5);
  return m;
}

Model commanded_general_model() {
  Model m = with_input(general_model(), "commanded_general", Hold::kFirstOrder);
  General& own = std::get<General>(m.structure);
  const Network before = own.dynamics;
  own.dynamics = random_network({6, 12, 3}, 24, 0.3);
  own.dynamics.skip = Eigen::MatrixXd::Zero(3, 6);
  own.dynamics.skip.leftCols(5) = before.skip;
  own.dynamics.skip.col(5) << 0.5, -1.0, 0.8;
  own.dynamics.output_scale.setOnes();
  own.dynamics.feature_scale.setOnes();
  return m;
}

Model commanded_gated_model() {
  Model m = with_input(gated_model(), "commanded_gated", Hold::kZeroOrder);
  Network map = random_network({5, 2}, 56, 1.1);  // reads only z
  map.features = Eigen::MatrixXd::Identity(5, 8);
  m.structure = Gated{random_network({8, 10}, 54, 0.8), random_network({8, 5}, 55, 0.9), map};
  return m;
}

Model failing_gated_model() {
  Model m = gated_model();
  m.name = "failing_gated";
  m.failures = {.outputs = {1}, .rest = Eigen::VectorXd::Constant(1, -0.5), .staleness_s = 0.05};
  const Gated own = std::get<Gated>(m.structure);
  Network map = own.inverse_map;
  map.features.conservativeResize(7, 8);  // T* does not read the staleness
  map.features.col(7).setZero();
  m.structure = Gated{random_network({8, 10}, 57, 0.8), random_network({8, 5}, 58, 0.9), map};
  return m;
}

Model carried_model() {
  Model m = blank("carried", 6, 3);
  m.output_max *= 2.0;
  m.output_min *= 2.0;
  for (const char* name : {"wx", "wy", "wz"}) m.inputs.push_back({name, "rad/s", 0.0});
  m.input_min = Eigen::VectorXd::Constant(3, -20.0);
  m.input_max = Eigen::VectorXd::Constant(3, 20.0);
  m.input_hold = Hold::kFirstOrder;
  m.initial_latent = Eigen::VectorXd::Zero(18);
  Carried own{.component = {.pairs = 1,
                            .eigenvalues = Eigen::Vector3d(-1.5, 2.0, -0.8),
                            .output_injection = Eigen::Vector3d(1.0, -0.5, 0.8),
                            .starts_steady = true},
              .inverse_map = {},
              .unit_length = true};
  // Weights of each of the three states on the modes of both vectors and on the vectors themselves, equal for all
  // components.
  Network& map = own.inverse_map;
  map.features = Eigen::MatrixXd::Identity(27, 27);
  map.feature_mean = Eigen::VectorXd::Zero(27);
  map.feature_scale = Eigen::VectorXd::Constant(27, 2.0);
  map.output_mean = Eigen::VectorXd::Zero(3);
  map.output_scale = Eigen::VectorXd::Constant(3, 0.5);
  map.layers = {{Eigen::MatrixXd::Zero(3, 27), Eigen::VectorXd::Zero(3)}};
  for (int c = 0; c < 3; ++c)
    for (int v = 0; v < 2; ++v) {
      for (int mode = 0; mode < 3; ++mode)
        map.layers[0].weights(c, (3 * v + c) * 3 + mode) = 0.9 - 0.4 * v - 0.5 * mode;
      map.layers[0].weights(c, 18 + 3 * v + c) = 0.3 - 0.7 * v;
    }
  m.structure = own;
  return with_domain(m);
}

Model prior_model() {
  Model m = blank("prior", 2, 2);
  m.inputs = {{"torque", "N m", 0.0}};
  m.input_min = Eigen::VectorXd::Constant(1, -2.0);
  m.input_max = Eigen::VectorXd::Constant(1, 2.0);
  m.initial_latent = Eigen::VectorXd::Zero(9);
  m.initial_latent << 0.1, 0.0, -0.2, 0.0, 0.3, -0.1, 1.5, 0.0, 2.0;
  Prior own{.equations = {{"x2", "mu * (1 - x1^2) * x2 - x1 + torque / 2"}, {"x1", "x2 - 0.5 * x1"}, {{"mu", 0.9}}},
            .state_min = Eigen::VectorXd{{-2.5, -4.0, 1e-9, -8.0, 1e-9}},
            .state_max = Eigen::VectorXd{{2.5, 3.5, 8.0, 8.0, 8.0}},
            .fine = Eigen::Vector2d(0.1, 0.2),
            .coarse = Eigen::Vector2d(2.0, 3.0),
            .state_noise = Eigen::Vector2d(1e-3, 2e-3),
            .output_noise = Eigen::Vector2d(0.02, 0.05),
            .gates = random_network({13, 8}, 91, 0.8),
            .candidate = random_network({13, 4}, 92, 0.9),
            .correction = random_network({13, 10}, 93, 0.1),
            .inverse_map = random_network({12, 8, 2}, 94, 1.2)};
  own.gates.output_scale.setOnes();
  own.gates.layers[0].bias.head(4) << -3.0, -2.0, -1.0, 0.0;
  m.structure = own;
  return with_domain(m);
}

Model prior_functions_model() {
  Model m = prior_model();
  m.name = "prior_functions";
  EquationTexts& equations = std::get<Prior>(m.structure).equations;
  equations.derivative = {"x2 + 0.1 * sin(x1) * sin(x1) - 0.2 * sqrt(max(x1, 0)) - 0.1 * min(x2, 0.5, 2 * x1)",
                          "(-3 * sin(x1) - b * x2 * abs(x2) + atan(torque) * cos(x1)) / (2 + cos(x1)^2) - 0.2 * "
                          "tanh(x2 / 0.2) - tan(x1 / 4) + 0.1 * sin(x1 - 0.3 * sin(x2))"};
  equations.outputs = {"x1 + 0.1 * ln(2 + x1^2) - exp(-x1^2 / 2)",
                       "x2 / sqrt(1 + x1^2) + 0.01 * sign(x2) - 0.2 * torque * x1"};
  equations.parameters = {{"b", 0.3}};
  return with_domain(m);
}

Model prior_unestimated_model() {
  Model m = prior_functions_model();
  m.name = "prior_unestimated";
  m.states = {m.states[1]};
  Prior& own = std::get<Prior>(m.structure);
  own.equations.unestimated = {"x1"};
  std::swap(own.equations.derivative[0], own.equations.derivative[1]);
  own.state_min = Eigen::VectorXd{{-4.0, -2.5, 1e-9, -8.0, 1e-9}};
  own.state_max = Eigen::VectorXd{{3.5, 2.5, 8.0, 8.0, 8.0}};
  own.inverse_map = random_network({12, 8, 1}, 95, 1.2);
  return with_domain(m);
}

namespace {

Model without_units(Model m, const std::string& name) {
  m.name = name;
  m.initial_latent = Eigen::VectorXd(m.initial_latent.tail(5));
  Prior& own = std::get<Prior>(m.structure);
  own.fine.resize(0);
  own.coarse.resize(0);
  own.gates = own.candidate = own.correction = {};
  own.inverse_map = random_network({8, m.nx()}, 96, 1.2);
  return with_domain(m);
}

}  // namespace

Model filter_model() {
  return without_units(prior_model(), "filter");
}

Model filter_functions_model() {
  return without_units(prior_functions_model(), "filter_functions");
}

Model hidden_joint_model() {
  Model m = blank("hidden_joint", 1, 4);
  m.sample_period_s = 0.002;
  m.inputs = {{"tau1", "N m", 0.0}, {"tau2", "N m", 0.0}};
  m.input_min = Eigen::Vector2d(-2.2, -2.6);
  m.input_max = Eigen::Vector2d(2.2, 2.8);
  m.output_min.setConstant(-3.5);
  m.output_max.setConstant(3.5);
  // Row by row: the angles, the speeds, and the triangle of their covariance.
  m.initial_latent = Eigen::VectorXd::Zero(14);
  m.initial_latent(4) = 0.2;
  m.initial_latent(8) = 0.5;
  m.initial_latent(11) = 8.6;
  m.initial_latent(13) = 24.9;
  const std::string first =
                        "(tau1 + h*sin(x2)*(2*x3*x4 + x4^2) - g1*sin(x1) - g2*sin(x1+x2) - b1*x3 - f1*tanh(x3/0.1))",
                    second = "(tau2 - h*sin(x2)*x3^2 - g2*sin(x1+x2) - b2*x4 - f2*tanh(x4/0.1))",
                    determinant = "(m1*m2 - h^2*cos(x2)^2)";
  Prior own;
  own.equations = {{"x3", "x4", "(m2*" + first + " - (m2 + h*cos(x2))*" + second + ")/" + determinant,
                    "((m1 + m2 + 2*h*cos(x2))*" + second + " - (m2 + h*cos(x2))*" + first + ")/" + determinant},
                   {"x1"},
                   {{"m1", 0.0596},
                    {"m2", 0.0627},
                    {"h", 0.0368},
                    {"g1", 2.28},
                    {"g2", 1.79},
                    {"b1", 0.005},
                    {"f1", 0.156},
                    {"b2", 0.0058},
                    {"f2", 0.0913}}};
  own.state_min = Eigen::VectorXd{{-3.5, -4.6, -19, -35, 2e-11, -5.1, -21, -36, 5e-11, -33, -57, 9e-10, -234, 2e-9}};
  own.state_max = Eigen::VectorXd{{3.5, 5.1, 21, 34, 3.3, 5.1, 21, 36, 8.1, 33, 57, 138, 234, 398}};
  own.state_noise = Eigen::Vector4d(2e-6, 7e-4, 2.9e-3, 1.3e-4);
  own.output_noise = Eigen::VectorXd::Constant(1, 6e-11);
  Network& passes_on = own.inverse_map = random_network({17, 4}, 97, 1.0);
  passes_on.layers[0].weights = Eigen::MatrixXd::Identity(4, 17);
  passes_on.layers[0].bias.setZero();
  passes_on.feature_mean.setZero();
  passes_on.feature_scale.setOnes();
  passes_on.output_mean.setZero();
  m.latent_min =
      Eigen::VectorXd{{-1.4, -1.7, -6.9, -15, -1e-6, -1e-6, -1e-6, -1e-6, -0.03, -0.1, -1.5, -0.8, -0.6, -2.5}};
  m.latent_max = Eigen::VectorXd{{1.4, 2.3, 9.2, 13, 4e-6, 1e-6, 1.4e-6, 1.2e-6, 0.6, 0.2, 0.5, 9.5, 1.3, 27}};
  m.structure = own;
  return m;
}

std::vector<Model> structure_models() {
  return {luenberger_model(), general_model(), gated_model(), driven_model(), carried_model(), prior_model()};
}

Model with_error(Model m, std::uint64_t seed) {
  m.name += "_error";
  const Eigen::Index width = inverse_map(m)->layers.back().weights.cols(), nx = m.nx();
  Uniform uniform(seed);
  m.error = ErrorHead{.weights = uniform.matrix(nx, 2 * width, 1.5 / std::sqrt(static_cast<double>(width))),
                      .bias = uniform.matrix(nx, 1, 0.5).array() - 1.0,
                      .log_min = Eigen::VectorXd::LinSpaced(nx, std::log(0.05), std::log(0.06)),
                      .log_max = Eigen::VectorXd::LinSpaced(nx, std::log(1.5), std::log(2.0)),
                      .factor_68 = Eigen::VectorXd::LinSpaced(nx, 0.9, 1.1),
                      .factor_95 = Eigen::VectorXd::LinSpaced(nx, 2.0, 2.3)};
  return m;
}

/// `driven_model` with a mode so fast that its phi functions are computed for a part of the step and doubled.
static Model fast_driven_model() {
  Model m = driven_model();
  linear_latent(m)->eigenvalues(2) = -80.0;
  linear_latent(m)->output_injection(2, 0) = 80.0;
  return m;
}

std::vector<Model> error_models() {
  return {with_error(rig_model(), 71),         with_error(saturating_rig_model(), 72),
          with_error(failing_model(), 73),     with_error(activation_model("relu"), 74),
          with_error(fast_driven_model(), 75), with_error(general_model(), 76),
          with_error(gated_model(), 77)};
}

std::vector<Model> example_models() {
  std::vector<Model> models = {paper_model(),
                               rig_model(),
                               two_rates_model(),
                               slow_angle_model(),
                               watched_two_rates_model(),
                               failing_two_rates_model(),
                               watched_failing_two_rates_model(),
                               tiny_model(),
                               activation_model("relu"),
                               activation_model("silu"),
                               activation_model("tanh"),
                               linear_model(),
                               hold_model("zero_order"),
                               hold_model("rk4"),
                               commanded_model(),
                               commanded_ramp_model(),
                               clocked_model(),
                               clocked_rig_model(),
                               fallback_model(),
                               failing_model(),
                               watched_model(),
                               watched_rig_model(),
                               watched_computed_model(),
                               failing_rig_model(),
                               computed_model(),
                               computed_gated_model(),
                               saturating_model(),
                               saturating_rig_model(),
                               commanded_luenberger_model(),
                               commanded_general_model(),
                               commanded_gated_model(),
                               failing_gated_model(),
                               contracting_gated_model(),
                               prior_functions_model(),
                               prior_unestimated_model(),
                               filter_model(),
                               filter_functions_model()};
  for (const Model& m : error_models()) models.push_back(m);
  for (const Model& m : structure_models()) models.push_back(m);
  return models;
}

Model flown(Model model, int runs, int samples, double share) {
  Uniform uniform(5);
  Flight& flight = model.flight;
  const Eigen::VectorXd half = (model.output_max - model.output_min) / 4.0;
  const Eigen::VectorXd middle = (model.output_max + model.output_min) / 2.0;
  flight.output_step.resize(model.ny());
  for (int j = 0; j < model.ny(); ++j)
    flight.output_step(j) = flight_step(2.0 * half(j), std::abs(middle(j)) + half(j));
  flight.input_step = Eigen::VectorXd::Constant(model.nu(), flight_step(2.0, 1.0));
  flight.dt_step_s = flight_step(16.0 * model.sample_period_s, 2.0 * model.sample_period_s);
  // An autoregression of order one with uniform noise, within +-1.
  const auto wander = [&](Eigen::Index n) {
    Eigen::VectorXd values(n);
    double value = uniform(1.0);
    for (double& v : values) v = value = 0.7 * value + 0.3 * uniform(1.0);
    return values;
  };
  for (int r = 0; r < runs; ++r) {
    FlightRun run{Eigen::MatrixXi(model.ny(), samples), Eigen::MatrixXi(model.nu(), samples), Eigen::VectorXi(samples)};
    for (int j = 0; j < model.ny(); ++j)
      run.outputs.row(j) = ((middle(j) + share * half(j) * wander(samples).array()) / flight.output_step(j))
                               .round()
                               .matrix()
                               .cast<int>();
    for (int i = 0; i < model.nu(); ++i)
      run.inputs.row(i) = (share * wander(samples).array() / flight.input_step(i)).round().matrix().cast<int>();
    const double period = model.sample_period_s / flight.dt_step_s;
    run.dt = (period * (1.0 + 0.3 * wander(samples).array())).round().matrix().cast<int>();
    flight.runs.push_back(run);
  }
  return model;
}

}  // namespace nlo::codegen
