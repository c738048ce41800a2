// SPDX-License-Identifier: MIT
// Rows about the arithmetic of exports. For each estimate, they compare float, 16-bit weights and int16 with real
// numbers.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/fold/quantise.h"
#include "codegen/model/domain.h"
#include "codegen/model/flown_ranges.h"
#include "codegen/replay/replay_run.h"
#include "codegen/targets/number_formats.h"
#include "trainer/judge/evaluation/text.h"
#include "trainer/prove/arithmetic_error.h"
#include "trainer/prove/certificate.h"
#include "trainer/prove/flown_map.h"
#include "trainer/prove/reachable_latent.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

struct Format {
  const char* id;
  codegen::ScalarType scalar;
  codegen::WeightType weights;
};
constexpr Format kFormats[] = {{"float", codegen::ScalarType::kFloat, codegen::WeightType::kFull},
                               {"bf16", codegen::ScalarType::kFloat, codegen::WeightType::kBfloat16},
                               {"int16", codegen::ScalarType::kInt16, codegen::WeightType::kFull}};

/// A model in one of these formats, and the searched region.
struct Flown {
  codegen::FoldedModel folded;
  std::optional<codegen::QuantisedModel> quantised;
  FlownMap map;
};

Flown flown_in(const codegen::Model& model, const Format& format, const JacobianEnclosure& real) {
  codegen::ExportOptions options;
  options.scalar = format.scalar;
  options.weights = format.weights;
  Flown flown{codegen::in_formats(codegen::fold(model), options), {}, {}};
  const codegen::FoldedNetwork& map = *flown.folded.inverse_map();
  if (format.scalar != codegen::ScalarType::kInt16) {
    flown.map = flown_in_float(real, map);
    return flown;
  }
  if (map.activation == Activation::kSilu && map.layers.size() > 1)
    throw codegen::Error("silu in int16 has no proven error; export with --scalar float");
  flown.quantised = codegen::quantise(model, flown.folded);
  const codegen::InputBox box = codegen::input_box(model, flown.folded);
  flown.map = flown_in_int16(real, flown.quantised->map,
                             codegen::largest_activations(*codegen::inverse_map(model), map, box), box.min, box.max);
  return flown;
}

/// Evaluates the exported and the exact map at points of the domain.
class MapSearch {
 public:
  MapSearch(const codegen::Model& model, const MapRegion& region, const Flown& flown)
      : model_(model),
        region_(region),
        flown_(flown),
        exact_(*codegen::inverse_map(model)),
        float_(unfolded(*flown.folded.inverse_map(), codegen::inverse_map(model)->inputs()),
               codegen::Activations::kRuntime) {}

  /// Returns |exported - exact| of each output, at q in +-1 of the region's box. Inputs are rounded to float.
  Vector at(const Vector& q) const {
    const Vector in = region_.inputs * (region_.box.centre + region_.box.radius.cwiseProduct(q));
    const Eigen::VectorXf given = in.cast<float>();
    Vector out;
    if (flown_.quantised) {
      out = codegen::evaluate(flown_.quantised->map, given.head(flown_.quantised->map.inputs())).cast<double>();
    } else {
      out = float_(given).cast<double>();
    }
    return (out - exact_(given.cast<double>())).cwiseAbs();
  }

  /// Returns the largest error at random points, and then at draws around the best point of each output.
  Vector largest(std::uint64_t seed) const {
    constexpr int kPoints = 4000, kDraws = 1500;
    constexpr double kInside = 1.0 - 1e-6;  // a rounded float near the end stays inside
    std::mt19937_64 engine(seed);
    const Index n = region_.box.centre.size();
    const auto draw = [&] {
      return Vector(Vector::NullaryExpr(n, [&] { return static_cast<double>(engine() >> 11) * 0x1p-52 - 1.0; }));
    };
    Matrix best = Matrix::Zero(n, model_.nx());
    Vector found = Vector::Zero(model_.nx());
    const auto keep = [&](const Vector& q) {
      const Vector error = at(q);
      for (Index i = 0; i < error.size(); ++i) {
        if (error(i) <= found(i)) continue;
        found(i) = error(i);
        best.col(i) = q;
      }
    };
    for (int k = 0; k < kPoints; ++k) keep(kInside * (k % 3 == 0 ? Vector(draw().cwiseSign()) : draw()));
    for (Index i = 0; i < model_.nx(); ++i) {
      double step = 0.3;
      for (int k = 0; k < kDraws; ++k) {
        const double before = found(i);
        keep((best.col(i) + step * draw()).cwiseMax(-kInside).cwiseMin(kInside));
        step = std::max(1e-6, step * (found(i) > before ? 1.3 : 0.98));
      }
    }
    return found;
  }

 private:
  const codegen::Model& model_;
  const MapRegion& region_;
  const Flown& flown_;
  codegen::ReferenceNetwork<double> exact_;
  codegen::ReferenceNetwork<float> float_;
};

/// Makes the readings of a flight: tones with faults, or constant levels. With constant levels, the flight stops early
/// once z in float no longer changes.
codegen::ReplayInputs flight(const codegen::Model& model, int stale_after, std::uint64_t seed, double amplitude,
                             bool levels) {
  constexpr int kSamples = 1500;
  codegen::ReplayInputs inputs = codegen::replay_inputs(model, stale_after, seed, kSamples, amplitude);
  if (!levels) return inputs;
  std::mt19937_64 engine(seed);
  const Vector low = codegen::reading_min(model), high = codegen::reading_max(model);
  Index left = 0;
  for (Index k = 0; k < kSamples; ++k, --left) {
    if (k > 0 && left > 0) {
      inputs.outputs.col(k) = inputs.outputs.col(k - 1);
      inputs.inputs.col(k) = inputs.inputs.col(k - 1);
      continue;
    }
    left = 1 + static_cast<Index>(engine() % (kSamples / 2));
    const auto level = [&](Index j) {
      const double u = static_cast<double>(engine() >> 11) * 0x1p-52 - 1.0;
      return 0.5 * (low(j) + high(j)) + 0.5 * amplitude * u * (high(j) - low(j));
    };
    for (Index j = 0; j < inputs.outputs.rows(); ++j) inputs.outputs(j, k) = level(j);
    for (Index j = 0; j < inputs.inputs.rows(); ++j) inputs.inputs(j, k) = level(model.ny() + j);
  }
  return inputs;
}

/// Compares the exported observer with the equations in double, as long as z stays in its domain.
Vector largest_in_flight(const codegen::Model& model, const Format& format, const Flown& flown, std::uint64_t seed) {
  constexpr int kRuns = 16;
  Vector found = Vector::Zero(model.nx());
  const codegen::LatentDomain domain(model);
  codegen::ReferenceObserver<double> exact(model);
  codegen::ExportedObserver exported(model, flown.folded, flown.quantised ? &*flown.quantised : nullptr, format.scalar);
  for (const double amplitude : {1.0, 0.5, 0.25, 0.1, 0.03}) {
    for (int run = 0; run < kRuns; ++run) {
      const codegen::ReplayInputs inputs = flight(model, flown.folded.stale_after, seed++, amplitude, run % 4 != 0);
      exact.reset();
      exported.reset();
      for (Index k = 0; k < inputs.outputs.cols(); ++k) {
        const Vector y = inputs.outputs.col(k).cast<float>().cast<double>();
        const Vector u = inputs.inputs.col(k).cast<float>().cast<double>();
        exact.step(y, u);
        exported.step(y, u, model.sample_period_s);
        if (!domain.contains(exact.latent(), exact.output())) break;
        const Vector off = exported.estimate(exported.latent(), exact.output()) -
                           exact.estimates(exact.latent(), exact.output()).col(0);
        found = found.cwiseMax(off.cwiseAbs());
      }
    }
  }
  return found;
}

/// Returns the reason why the steps of z have no row; empty if they have one.
std::string steps_left_out(const codegen::Model& model) {
  if (!moves_linearly(model))
    return fmt::format("the steps of z are not included for structure {}", codegen::structure_name(model));
  if (codegen::flown_ranges(model).any_wraps())
    return "the steps of z are not included, because an output is an angle that wraps";
  if (!model.failures.outputs.empty()) return "the steps of z are not included, because outputs may be missing";
  if (model.measured() != model.ny())
    return "the steps of z are not included, because some outputs are computed from others";
  return "";
}

}  // namespace

CertificateRows arithmetic_rows(const codegen::Model& model, const CertifyOptions& options) {
  constexpr std::int64_t kBoxes = 4000;
  constexpr const char* kWhat = "|exported - real| of an estimate";
  CertificateRows rows;
  if (const std::string why = reason_against_map(model); !why.empty()) return {absent_row("arithmetic", kWhat, why)};
  const MapRegion region = domain_region(model);
  const Index n = region.inputs.rows();
  const Matrix identity = Matrix::Identity(n, n);
  const JacobianEnclosure real(*codegen::inverse_map(model), identity, identity);
  const std::string left_out = steps_left_out(model);
  for (const Format& format : kFormats) {
    const std::string id = fmt::format("arithmetic.{}", format.id);
    Flown flown;
    try {
      flown = flown_in(model, format, real);
    } catch (const codegen::Error& error) {
      rows.push_back(absent_row(id, kWhat, error.what()));
      continue;
    }
    Vector latent_off = Vector::Zero(model.nz());
    const MapSearch search(model, region, flown);
    Vector found = search.largest(options.seed);
    if (left_out.empty()) {
      latent_off = float_latent_error(model, model.latent_min, model.latent_max);
      found = found.cwiseMax(largest_in_flight(model, format, flown, options.seed));
    }
    const ArithmeticError error = arithmetic_error(model, region, flown.map, latent_off, found,
                                                   options.boxes > 0 ? options.boxes : kBoxes, options.gap);
    for (Index i = 0; i < model.nx(); ++i) {
      const codegen::Channel& state = model.states[static_cast<std::size_t>(i)];
      CertificateRow row;
      row.id = fmt::format("{}.{}", id, state.name);
      row.what = fmt::format("|{} exported in {} - {} in real numbers|", state.name, format.id, state.name);
      row.unit = state.unit;
      row.bound = error.bound(i);
      row.found = found(i);
      row.where =
          left_out.empty() ? "at draws in the domain, and in flights that stayed in it" : "at draws in the domain";
      row.note =
          left_out.empty()
              ? fmt::format(
                    "after any number of steps, while z and readings stay in the domain; the error of z is at most {}",
                    significant(latent_off.maxCoeff(), 2))
              : "error of T* alone, for the exported z; " + left_out;
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

}  // namespace nlo::trainer
