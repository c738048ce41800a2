// SPDX-License-Identifier: MIT
#include "codegen/structures/linear_latent_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <string>
#include <vector>

#include "codegen/model/domain.h"
#include "codegen/model/field_checks.h"
#include "codegen/model/hold.h"
#include "codegen/model/latent_step.h"

namespace nlo::codegen {
namespace {

// |lambda h| beyond which a latent state only copies the output: e^-1000 is zero in any precision.
constexpr double kFastest = 1000.0;

/// Returns A, the factor by which an eigenvalue multiplies its part of z in one sample, in float32.
std::complex<float> step_factor(std::complex<double> lambda, double h, Hold hold) {
  const auto mode =
      discretise(hold == Hold::kRk4 ? Hold::kRk4 : Hold::kFirstOrder, Complex<double>{lambda.real(), lambda.imag()}, h);
  return {static_cast<float>(1.0 + mode.a_minus_1.re), static_cast<float>(mode.a_minus_1.im)};
}

/// Returns the decay rate of each mode that reads an output. A clock reads none.
std::vector<double> driven_rates(const LinearLatent& latent) {
  std::vector<double> rates;
  for (int r = 0; r < latent.eigenvalues.size(); ++r) {
    const bool paired = r < 2 * latent.pairs;
    if (!latent.output_injection.middleRows(r, paired ? 2 : 1).isZero(0.0)) rates.push_back(-latent.eigenvalues(r));
    if (paired) ++r;
  }
  return rates;
}

/// Checks that the clock of a feature is a latent state that starts at 1 and has no input.
void check_feature_clocks(const Model& m) {
  const LinearLatent& latent = *linear_latent(m);
  const std::vector<int>& clocks = inverse_map(m)->feature_clocks;
  for (std::size_t f = 0; f < clocks.size(); ++f) {
    const int row = clocks[f];
    if (row == -1) continue;
    if (row < 2 * latent.pairs || row >= m.nz() || !latent.output_injection.row(row).isZero(0.0) ||
        m.initial_latent(row) != 1.0)
      fail(
          "inverse_map.feature_clocks[{}] is {}; it must be -1 or a row of z that is a clock: a real eigenvalue, a "
          "zero "
          "row of output_injection and an initial_latent of 1",
          f, row);
  }
}

}  // namespace

void read_linear_latent(const Field& file, LinearLatent& latent) {
  latent.starts_steady = boolean(file["starts_steady"]);
  if (file.has("relative_outputs")) {
    const Field list = file["relative_outputs"];
    for (std::size_t i = 0; i < list.array_size(); ++i) latent.relative_outputs.push_back(small_integer(list[i]));
  }
  latent.pairs = small_integer(file["pairs"]);
  latent.eigenvalues = vector(file["eigenvalues"]);
  latent.output_injection = matrix(file["output_injection"]);
}

void write_linear_latent(const LinearLatent& latent, JsonObject& file) {
  file.field("starts_steady", latent.starts_steady ? "true" : "false");
  if (!latent.relative_outputs.empty())
    file.field("relative_outputs",
               fmt::format("[{}]", fmt::join(latent.relative_outputs.begin(), latent.relative_outputs.end(), ", ")));
  file.field("pairs", std::to_string(latent.pairs));
  file.vector("eigenvalues", latent.eigenvalues);
  file.matrix("output_injection", latent.output_injection);
}

void check_linear_latent(const Model& m) {
  const LinearLatent& latent = *linear_latent(m);
  const int nz = m.nz();
  if (latent.pairs < 0 || 2 * latent.pairs > nz)
    fail("pairs is {}; with {} latent states it must be 0 to {}", latent.pairs, nz, nz / 2);
  check_shape(latent.eigenvalues, nz, "eigenvalues", "n_z, the size of initial_latent");
  check_shape(latent.output_injection, nz, m.nr(), "output_injection",
              !m.inputs.empty()   ? "n_z x (n_y + n_u)"
              : m.failures.none() ? "n_z x n_y"
                                  : "n_z x n_r: outputs, then stalenesses");

  for (Eigen::Index i = 0; i < nz; ++i) {
    const bool paired = i < 2 * latent.pairs;
    const std::complex<double> lambda(latent.eigenvalues(i), paired ? latent.eigenvalues(i + 1) : 0.0);
    if (!(lambda.real() < 0.0))
      fail("eigenvalues[{}] is {}; its real part must be negative (D must be Hurwitz), or z never forgets its start", i,
           lambda.real());
    if (!(std::abs(lambda) * m.sample_period_s < kFastest))
      fail("eigenvalues[{}] is {}; at the sample period of {} s this exceeds {} per sample: use a slower eigenvalue", i,
           lambda.real(), m.sample_period_s, kFastest);
    const double radius = std::abs(std::complex<double>(step_factor(lambda, m.sample_period_s, m.hold)));
    if (!(radius < 1.0))
      fail("eigenvalues[{}] is {} and makes |A| = {} at the sample period of {} s (rounded to float); {}", i,
           lambda.real(), radius, m.sample_period_s,
           m.hold == Hold::kRk4
               ? "rk4 is unstable here: use hold first_order, or a shorter sample period"
               : "it is so slow that float cannot distinguish it from an integrator: use a faster eigenvalue");
    if (paired) ++i;
  }
  // Uses the effect on z of a reading of 1, even if a reading is always small.
  const Eigen::MatrixXd gain = steady_gain(m);
  for (Eigen::Index i = 0; i < nz; ++i)
    if (!(latent.output_injection.row(i).cwiseAbs().maxCoeff() <= kLargestNumber &&
          gain.row(i).cwiseAbs().maxCoeff() <= kLargestNumber))
      fail("output_injection[{}] reaches {} and its steady state {}; float32 requires them within +-{}", i,
           latent.output_injection.row(i).cwiseAbs().maxCoeff(), gain.row(i).cwiseAbs().maxCoeff(), kLargestNumber);
  for (std::size_t i = 0; i < latent.relative_outputs.size(); ++i) {
    const int output = latent.relative_outputs[i];
    if (output < 0 || output >= m.ny() || (i > 0 && output <= latent.relative_outputs[i - 1]))
      fail("relative_outputs[{}] is {}; write numbers of outputs, from 0 to {}, in increasing order", i, output,
           m.ny() - 1);
  }
}

Eigen::VectorXd largest_latent(const Model& m) {
  const LinearLatent& latent = *linear_latent(m);
  const StepMatrices step = latent_step(m, m.sample_period_s);
  const Eigen::VectorXd readings = largest_readings(m);
  const Eigen::VectorXd slopes = latent.output_injection.cwiseAbs() * readings;
  const Eigen::VectorXd pushes = (step.b0.cwiseAbs() + step.b1.cwiseAbs()) * readings;
  const Eigen::VectorXd start = m.initial_latent.cwiseAbs() + steady_gain(m).cwiseAbs() * readings;
  Eigen::VectorXd largest(m.nz());
  for (int r = 0; r < m.nz();) {
    const int size = r < 2 * latent.pairs ? 2 : 1;  // a pair turns and keeps its norm
    const double radius = std::hypot(1.0 + step.a_minus_1(r), size == 2 ? step.a_minus_1(r + 1) : 0.0);
    const double reached =
        start.segment(r, size).norm() + std::max(slopes.segment(r, size).norm() / -latent.eigenvalues(r),
                                                 pushes.segment(r, size).norm() / (1.0 - radius));
    if (!(reached < kLargestNumber))
      fail(
          "initial_latent[{0}], output_injection[{0}] and the ranges of the readings let z[{0}] reach {1}; it must "
          "stay "
          "below {2}",
          r, reached, kLargestNumber);
    largest.segment(r, size).setConstant(reached);
    r += size;
  }
  return largest;
}

void check_latent_map(const Model& m) {
  check_network(*inverse_map(m), m.nz() + m.nr(), m.nx(), "inverse_map",
                !m.inputs.empty() ? "n_u x (n_z + n_y + inputs)" : "n_u x (n_z + n_y)");
  check_feature_clocks(m);
  const Eigen::VectorXd latent = largest_latent(m);  // the ranges as flown depend on the features, whose shape is known
  Eigen::VectorXd reads(m.nz() + m.nr());
  reads << latent, largest_readings(m);
  check_sums(*inverse_map(m), reads, "inverse_map");
  for (int j = 0; j < m.ny(); ++j) {
    if (m.outputs[static_cast<std::size_t>(j)].wrap == 0.0) continue;
    for (const auto& [feature, change] : seen_of_turn(m, j))
      fail(
          "inverse_map.features[{}] changes by {} per unit of the angle outputs[{}] (\"{}\"); T* may read an angle "
          "only as z - S y (S = -D^-1 F), or as sine and cosine",
          feature, change, j, m.outputs[static_cast<std::size_t>(j)].name);
  }
}

double fastest_driven_mode(const LinearLatent& latent) {
  double fastest = 0.0;
  for (const double rate : driven_rates(latent)) fastest = std::max(fastest, rate);
  return fastest;
}

std::optional<double> slowest_driven_mode(const LinearLatent& latent) {
  const std::vector<double> rates = driven_rates(latent);
  if (rates.empty()) return std::nullopt;
  return *std::min_element(rates.begin(), rates.end());
}

Eigen::Index reads_of(const Network& map, const Model& m) {
  return map.features.rightCols(m.nr()).isZero(0.0) ? m.nz() : map.features.cols();
}

KklHeader::KklHeader(const ExportSource& source) : CppStructureBase(source), latent_(*linear_latent(source.model)) {}

std::string KklHeader::description() const {
  return fmt::format("// Latent state: {} ({}), {} hold. Inverse map T*: {}.\n", nz_,
                     counted(std::to_string(latent_.pairs), "complex pair"), hold_name(m_.hold),
                     inverse_map().description()) +
         input_comment();
}

std::string KklHeader::model_type() const {
  return fmt::format("KklModel<{}, {}, {}, {}, {}, {}{}>;  // n_x, n_y, n_z, complex pairs{}\n", init_.scalar_name(),
                     nx_, ny_, nz_, latent_.pairs, inverse_map().map_type(init_), input_arguments(),
                     input_words().empty() ? "" : ", T*" + input_words());
}

Eigen::Index KklHeader::own_scalars() const {
  const auto bytes = static_cast<Eigen::Index>(init_.scalar_bytes());
  const Eigen::Index flags = (1 + nr_ + bytes - 1) / bytes;  // starts_steady and relative
  // eigenvalues, F, A, B0, B1, S, initial; stale_after and hold by alignment
  return nz_ + nz_ * nr_ + (nz_ + 2 * nz_ * nr_) + nz_ * nr_ + nz_ + 2 + flags + (m_.saturates() ? 2 * nz_ : 0) +
         (saturates_relative(m_) ? nz_ * nr_ : 0);
}

Eigen::Index KklHeader::estimate_multiply_adds() const {
  return CppStructureBase::estimate_multiply_adds() + (saturates_relative(m_) ? nz_ * nr_ : 0);
}

std::string KklHeader::trailing_fields() const {
  if (!m_.saturates()) return CppStructureBase::trailing_fields();
  const LatentReach reach(m_);
  const std::string gain = !saturates_relative(m_)
                               ? ""
                               : ",\n              .steady_gain = " +
                                     init_.matrix(LatentDomain(m_).relative_gain().transpose(), "steady_gain");
  return CppStructureBase::trailing_fields() + fmt::format("    .reach = {{.min = {},\n              .max = {}{}}},\n",
                                                           init_.vector(reach.min, "saturation"),
                                                           init_.vector(reach.max, "saturation"), gain);
}

std::string KklHeader::latent_fields() const {
  std::string text = "    .latent = {\n";
  text += fmt::format("        .hold = {},\n", hold_identifier(m_.hold));
  text += fmt::format("        .eigenvalues = {},  // 1/s\n", init_.vector(latent_.eigenvalues, "eigenvalues"));
  text += fmt::format("        .output_injection = {},\n", init_.matrix(latent_.output_injection, "output_injection"));
  text += "        .step = " + step(f_.step, 17) + ",\n";
  text += fmt::format("        .steady_gain = {},\n", init_.matrix(f_.steady_gain, "steady_gain"));
  text += fmt::format("        .initial = {},\n", init_.vector(m_.initial_latent, "initial_latent"));
  text += fmt::format("        .starts_steady = {},\n", latent_.starts_steady);
  if (!latent_.relative_outputs.empty()) {
    std::string list;
    for (int j = 0; j < m_.nr(); ++j) list += fmt::format("{}{}", j == 0 ? "" : ", ", is_relative(m_, j));
    text += fmt::format("        .relative = {{{}}},\n", list);
  }
  return text + "    },\n";
}

std::string KklHeader::step(const StepMatrices& step, std::size_t indent) const {
  const std::string space(indent, ' ');
  return fmt::format("{{.a_minus_1 = {},\n{}.b0 = {},\n{}.b1 = {}}}", init_.vector(step.a_minus_1, "A"), space,
                     init_.matrix(step.b0, "B0"), space, init_.matrix(step.b1, "B1"));
}

}  // namespace nlo::codegen
