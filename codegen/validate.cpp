// SPDX-License-Identifier: MIT
#include "codegen/validate.h"

#include <fmt/format.h>

#include <nlo/latent.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <string>

#include "codegen/error.h"

namespace nlo::codegen {
namespace {

// Keywords and alternative tokens of C++20 and C, macros of the standard headers, and names that a generated header
// has taken itself. Sorted.
constexpr std::array kReservedWords = {
    "EOF",       "Eigen",         "INFINITY",    "NAN",       "NULL",         "Output",    "State",
    "alignas",   "alignof",       "and",         "and_eq",    "asm",          "assert",    "auto",
    "bitand",    "bitor",         "bool",        "break",     "case",         "catch",     "char",
    "char16_t",  "char32_t",      "char8_t",     "class",     "co_await",     "co_return", "co_yield",
    "codegen",   "compl",         "concept",     "const",     "const_cast",   "consteval", "constexpr",
    "constinit", "continue",      "decltype",    "default",   "delete",       "detail",    "do",
    "double",    "dynamic_cast",  "else",        "enum",      "errno",        "explicit",  "export",
    "extern",    "false",         "float",       "for",       "friend",       "goto",      "if",
    "inline",    "int",           "kernels",     "linux",     "long",         "mutable",   "namespace",
    "new",       "nlo",           "noexcept",    "not",       "not_eq",       "nullptr",   "operator",
    "or",        "or_eq",         "private",     "protected", "public",       "register",  "reinterpret_cast",
    "requires",  "restrict",      "return",      "setjmp",    "short",        "signed",    "sizeof",
    "static",    "static_assert", "static_cast", "std",       "stderr",       "stdin",     "stdout",
    "struct",    "switch",        "template",    "this",      "thread_local", "throw",     "trainer",
    "true",      "try",           "typedef",     "typeid",    "typename",     "union",     "unix",
    "unsigned",  "using",         "virtual",     "void",      "volatile",     "wchar_t",   "while",
    "xor",       "xor_eq"};

// Rounding in features * [S; I] is a few units in the last place of its largest term; a feature that really reads an
// angle is off by a fraction of one.
constexpr double kTurnTolerance = 1e-9;

// |lambda h| beyond which a latent state is a copy of the output: e^-1000 is zero in any precision.
constexpr double kFastest = 1000.0;

template <class... Args>
[[noreturn]] void fail(fmt::format_string<Args...> format, Args&&... args) {
  throw Error(fmt::format(format, std::forward<Args>(args)...));
}

void check_shape(const Eigen::MatrixXd& m, Eigen::Index rows, Eigen::Index cols, const std::string& field,
                 const char* meaning) {
  if (m.rows() != rows || m.cols() != cols)
    fail("{} is {} x {}; it must be {} x {} ({})", field, m.rows(), m.cols(), rows, cols, meaning);
  for (Eigen::Index i = 0; i < rows; ++i)
    for (Eigen::Index j = 0; j < cols; ++j)
      if (!std::isfinite(m(i, j)))
        fail("{}[{}][{}] is not finite ({}); train again, or take the last good checkpoint", field, i, j, m(i, j));
}

void check_shape(const Eigen::VectorXd& v, Eigen::Index size, const std::string& field, const char* meaning) {
  if (v.size() != size) fail("{} has {} entries; it must have {} ({})", field, v.size(), size, meaning);
  for (Eigen::Index i = 0; i < size; ++i)
    if (!std::isfinite(v(i)))
      fail("{}[{}] is not finite ({}); train again, or take the last good checkpoint", field, i, v(i));
}

void check_positive(const Eigen::VectorXd& v, const char* field) {
  for (Eigen::Index i = 0; i < v.size(); ++i)
    if (!(v(i) > 0.0)) fail("{}[{}] is {}; a scale must be positive", field, i, v(i));
}

void check_range(const Eigen::VectorXd& low, const Eigen::VectorXd& high, const char* field) {
  for (Eigen::Index i = 0; i < low.size(); ++i)
    if (!(low(i) < high(i)))
      fail("{0}_min[{1}] is {2} and {0}_max[{1}] is {3}; the minimum must be smaller", field, i, low(i), high(i));
}

void check_channels(const std::vector<Channel>& channels, const char* field) {
  if (channels.empty()) fail("{} is empty; a model has at least one of them", field);
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const Channel& channel = channels[i];
    if (!is_identifier(channel.name))
      fail(
          "{}[{}].name is no identifier; use a letter, then letters, digits and underscores (63 at most), no C++ "
          "keyword",
          field, i);
    if (!(channel.wrap >= 0.0) || !std::isfinite(channel.wrap))
      fail("{}[{}].wrap is {}; give the full turn of an angle in its unit (6.283185307179586 for rad), or 0", field, i,
           channel.wrap);
    for (std::size_t j = 0; j < i; ++j)
      if (channels[j].name == channel.name)
        fail("{0}[{1}].name and {0}[{2}].name are both \"{3}\"; rename one", field, j, i, channel.name);
  }
}

/// A, the factor that an eigenvalue puts on its part of z in one sample, as float32 sees it.
std::complex<float> step_factor(std::complex<double> lambda, double h, const std::string& hold) {
  const auto mode =
      discretise(hold == "rk4" ? Hold::kRk4 : Hold::kFirstOrder, Complex<double>{lambda.real(), lambda.imag()}, h);
  return {static_cast<float>(1.0 + mode.a_minus_1.re), static_cast<float>(mode.a_minus_1.im)};
}

void check_latent(const Model& m) {
  const auto nz = m.eigenvalues.size();
  if (nz == 0) fail("eigenvalues is empty; an observer has at least one latent state");
  if (!(m.sample_period_s > 0.0) || !std::isfinite(m.sample_period_s))
    fail("sample_period_s is {}; it must be positive", m.sample_period_s);
  if (m.hold != "zero_order" && m.hold != "first_order" && m.hold != "rk4")
    fail("hold is unknown; use zero_order, first_order or rk4");
  if (m.pairs < 0 || 2 * static_cast<Eigen::Index>(m.pairs) > nz)
    fail("pairs is {}; with {} eigenvalues it must be 0 to {}", m.pairs, nz, nz / 2);
  check_shape(m.eigenvalues, nz, "eigenvalues", "n_z");
  check_shape(m.output_injection, nz, m.ny(), "output_injection", "n_z x n_y");
  check_shape(m.initial_latent, nz, "initial_latent", "n_z");
  check_shape(m.latent_min, nz, "latent_min", "n_z");
  check_shape(m.latent_max, nz, "latent_max", "n_z");
  check_range(m.latent_min, m.latent_max, "latent");

  for (Eigen::Index i = 0; i < nz; ++i) {
    const bool paired = i < 2 * m.pairs;
    const std::complex<double> lambda(m.eigenvalues(i), paired ? m.eigenvalues(i + 1) : 0.0);
    if (!(lambda.real() < 0.0))
      fail("eigenvalues[{}] is {}; its real part must be negative (D must be Hurwitz), or z never forgets its start", i,
           lambda.real());
    if (!(std::abs(lambda) * m.sample_period_s < kFastest))
      fail("eigenvalues[{}] is {}; at the sample period of {} s that is beyond {} per sample: use a slower one", i,
           lambda.real(), m.sample_period_s, kFastest);
    const double radius = std::abs(std::complex<double>(step_factor(lambda, m.sample_period_s, m.hold)));
    if (!(radius < 1.0))
      fail("eigenvalues[{}] is {} and makes |A| = {} at the sample period of {} s (rounded to float); {}", i,
           lambda.real(), radius, m.sample_period_s,
           m.hold == "rk4" ? "rk4 is unstable here: use hold first_order, or a shorter sample period"
                           : "it is too slow to be told from an integrator: use a faster eigenvalue");
    if (paired) ++i;
  }
}

void check_inverse_map(const Model& m) {
  const auto nu = m.features.rows();
  if (nu == 0) fail("features is empty; the inverse map must read something");
  check_shape(m.features, nu, m.nz() + m.ny(), "features", "n_u x (n_z + n_y)");
  check_shape(m.feature_mean, nu, "feature_mean", "n_u, the rows of features");
  check_shape(m.feature_scale, nu, "feature_scale", "n_u, the rows of features");
  check_positive(m.feature_scale, "feature_scale");
  if (m.activation != "tanh" && m.activation != "relu" && m.activation != "silu")
    fail("activation is unknown; use tanh, relu or silu");

  if (m.layers.empty()) fail("layers is empty; a linear map is one layer");
  Eigen::Index inputs = nu;
  for (std::size_t l = 0; l < m.layers.size(); ++l) {
    const bool last = l + 1 == m.layers.size();
    const DenseLayer& layer = m.layers[l];
    const auto outputs = last ? static_cast<Eigen::Index>(m.nx()) : layer.weights.rows();
    if (outputs == 0) fail("layers[{}].weights is empty; a layer has at least one neuron", l);
    check_shape(layer.weights, outputs, inputs, fmt::format("layers[{}].weights", l),
                last ? "n_x x the neurons of the layer before" : "neurons x what the layer reads");
    check_shape(layer.bias, outputs, fmt::format("layers[{}].bias", l), "the rows of its weights");
    inputs = outputs;
  }
  if (m.skip.size() != 0 || m.skip.rows() != 0) check_shape(m.skip, m.nx(), nu, "skip", "n_x x n_u, or [] for none");
  check_shape(m.state_mean, m.nx(), "state_mean", "n_x");
  check_shape(m.state_scale, m.nx(), "state_scale", "n_x");
  check_positive(m.state_scale, "state_scale");
}

/// When an angle turns once, z turns with it by S wrap; T* must not see that.
void check_turns(const Model& m) {
  const Eigen::MatrixXd gain = steady_gain(m);
  for (int j = 0; j < m.ny(); ++j) {
    if (m.outputs[static_cast<std::size_t>(j)].wrap == 0.0) continue;
    Eigen::VectorXd turn = Eigen::VectorXd::Zero(m.nz() + m.ny());
    turn.head(m.nz()) = gain.col(j);
    turn(m.nz() + j) = 1.0;
    const Eigen::VectorXd seen = m.features * turn;
    // Against the largest entry of S, not each row's own: the quadrature part of a unit-gain pair is a rounded zero.
    const Eigen::VectorXd largest = m.features.rowwise().lpNorm<1>() * turn.lpNorm<Eigen::Infinity>();
    for (Eigen::Index i = 0; i < seen.size(); ++i)
      if (std::abs(seen(i)) > kTurnTolerance * largest(i))
        fail(
            "features[{}] changes by {} per unit of the angle outputs[{}] (\"{}\"); T* may read an angle only as z - S "
            "y "
            "(S = -D^-1 F), or as sine and cosine",
            i, seen(i), j, m.outputs[static_cast<std::size_t>(j)].name);
  }
}

}  // namespace

bool is_identifier(std::string_view text) {
  constexpr std::size_t kLongest = 63;  // what C99 promises to tell apart, and one more
  const auto is_letter = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); };
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  return !text.empty() && text.size() <= kLongest && is_letter(text.front()) &&
         std::all_of(text.begin(), text.end(), [&](char c) { return is_letter(c) || is_digit(c) || c == '_'; }) &&
         text.find("__") == std::string_view::npos &&  // reserved to the compiler anywhere in a name
         std::find(kReservedWords.begin(), kReservedWords.end(), text) == kReservedWords.end();
}

Eigen::MatrixXd steady_gain(const Model& m) {
  Eigen::MatrixXd gain(m.output_injection.rows(), m.output_injection.cols());
  for (int p = 0; p < m.pairs; ++p) {
    const double re = m.eigenvalues(2 * p), im = m.eigenvalues(2 * p + 1), square = re * re + im * im;
    const auto f_re = m.output_injection.row(2 * p), f_im = m.output_injection.row(2 * p + 1);
    gain.row(2 * p) = -(re * f_re + im * f_im) / square;
    gain.row(2 * p + 1) = -(re * f_im - im * f_re) / square;
  }
  for (Eigen::Index i = 2 * m.pairs; i < m.eigenvalues.size(); ++i)
    gain.row(i) = -m.output_injection.row(i) / m.eigenvalues(i);
  return gain.array() + 0.0;  // -0 becomes 0
}

void validate(const Model& m) {
  if (!is_identifier(m.name))
    fail("name is no identifier; use a letter, then letters, digits and underscores (63 at most), no C++ keyword");
  check_channels(m.outputs, "outputs");
  check_channels(m.states, "states");
  check_latent(m);
  check_shape(m.output_min, m.ny(), "output_min", "n_y");
  check_shape(m.output_max, m.ny(), "output_max", "n_y");
  check_range(m.output_min, m.output_max, "output");
  check_inverse_map(m);
  check_turns(m);
  for (std::size_t i = 0; i < m.provenance.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (m.provenance[i].first == m.provenance[j].first)
        fail("provenance has \"{}\" twice; keep one", m.provenance[i].first);
}

}  // namespace nlo::codegen
