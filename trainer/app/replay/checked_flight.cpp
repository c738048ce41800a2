// SPDX-License-Identifier: MIT
#include "trainer/app/replay/checked_flight.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>

#include "codegen/base/fail.h"
#include "codegen/targets/c99.h"
#include "codegen/targets/cpp_header.h"
#include "codegen/targets/golden_replay.h"
#include "codegen/targets/observers_in.h"
#include "trainer/app/replay/flight_log.h"
#include "trainer/app/replay/flown_export.h"

namespace nlo::trainer {
namespace {

using codegen::GeneratedObserver;
using codegen::PreparedExport;
using codegen::TextForm;
using Eigen::Index;
using Eigen::MatrixXd;

// Tolerance of a golden replay as a multiple of the error of its emulation, because some networks amplify rounding. A
// wrong number has a much larger effect.
constexpr double kTimesGolden = 16.0, kShareInFloat = 1e-4, kShareInDouble = 1e-9;

constexpr const char* kNothingWritten = "nothing is written: this is a bug of nlo, please report it with the model";

std::string files_of(const GeneratedObserver& observer) {
  return observer.name + (observer.form == TextForm::kC99 ? ".h and .c" : ".h");
}

MatrixXd given(const codegen::Model& m, const codegen::ReplayInputs& inputs) {
  MatrixXd rows(kGivenReading + m.measured() + m.nu(), inputs.dt_s.size());
  for (Index k = 0; k < rows.cols(); ++k) rows(kGivenCommand, k) = inputs.dt_s(k) > 0.0 ? kStepOverDt : kStep;
  rows.row(kGivenDt) = inputs.dt_s.transpose();
  rows.middleRows(kGivenReading, m.measured()) = inputs.outputs.topRows(m.measured());
  rows.bottomRows(m.nu()) = inputs.inputs;
  return rows;
}

void check_answers(const PreparedExport& prepared, const codegen::GoldenReplay& golden, const MatrixXd& answers,
                   const std::string& files) {
  const double share = prepared.initialiser().scalar_bytes() == 4 ? kShareInFloat : kShareInDouble;
  const Eigen::VectorXd largest = golden.run.x_hat.cwiseAbs().rowwise().maxCoeff();
  const Eigen::VectorXd tolerance = (kTimesGolden * golden.x_hat_tolerance).cwiseMax(share * largest);
  for (Index k = 0; k < answers.cols(); ++k) {
    const auto status = static_cast<int>(golden.run.status[static_cast<std::size_t>(k)]);
    if (answers(kAnswerStatus, k) != status)
      codegen::fail("{}: sample {} of the replay gives the status {}, but the model gives {}; {}", files, k,
                    status_word(answers(kAnswerStatus, k)), status_word(status), kNothingWritten);
    for (int i = 0; i < prepared.model().nx(); ++i) {
      const double got = answers(kAnswerEstimate + i, k), want = golden.run.x_hat(i, k);
      if (!(std::abs(got - want) <= tolerance(i)))
        codegen::fail(
            "{}: sample {} of the replay gives {} as {}, but the model gives {}; the difference exceeds {:.2g}, "
            "which its arithmetic explains; {}",
            files, k, prepared.model().states[static_cast<std::size_t>(i)].name, got, want, tolerance(i),
            kNothingWritten);
    }
  }
}

void check_bits(const PreparedExport& prepared, const MatrixXd& answers, const MatrixXd& others,
                const std::string& files, const std::string& other) {
  for (Index k = 0; k < answers.cols(); ++k)
    for (Index i = 0; i < answers.rows(); ++i) {
      if (std::bit_cast<std::uint64_t>(answers(i, k)) == std::bit_cast<std::uint64_t>(others(i, k))) continue;
      const std::string what = i == kAnswerStatus ? "the status"
                               : i == kAnswerInDomain
                                   ? "in_domain"
                                   : prepared.model().states[static_cast<std::size_t>(i - kAnswerEstimate)].name;
      codegen::fail("{}: sample {} of the replay gives {} as {}, but {} gives {}: they must agree bit for bit; {}",
                    files, k, what, answers(i, k), other, others(i, k), kNothingWritten);
    }
}

/// Returns the observer in the other language, if both languages support these number formats.
std::optional<CompiledText> other_language(const PreparedExport& prepared, const GeneratedObserver& observer) {
  const codegen::ExportOptions& options = prepared.options();
  if (options.weights != codegen::WeightType::kFull || options.tanh != Activation::kTanh) return std::nullopt;
  if (observer.form == TextForm::kCpp)
    return CompiledText{{TextForm::kC99, observer.name, codegen::c99(prepared)}, "", false};
  return CompiledText{
      {TextForm::kCpp, observer.name, {{observer.name + ".h", codegen::cpp_header(prepared)}}}, "", true};
}

}  // namespace

std::string check_flight(const PreparedExport& prepared, const std::vector<codegen::NamedText>& files) {
  std::string seen;
  for (const GeneratedObserver& observer : codegen::observers_in(files)) {
    const PreparedExport same = codegen::named(prepared, observer.name);
    const bool cpp = observer.form == TextForm::kCpp;
    const PreparedExport flown = cpp ? same : codegen::for_c99(same, "c99");
    const codegen::GoldenReplay golden = codegen::golden_replay(flown);
    const MatrixXd rows = given(flown.model(), golden.run.inputs);
    const std::string name = files_of(observer);
    const MatrixXd answers = FlownExport(flown, {observer, "", false}).run(rows);
    check_answers(flown, golden, answers, name);
    seen += fmt::format("{}: compiled; agrees with the model over {} samples", name, rows.cols());
    if (const std::optional<CompiledText> other = other_language(flown, observer)) {
      const MatrixXd own = cpp ? FlownExport(flown, {observer, "", true}).run(rows) : answers;
      check_bits(flown, own, FlownExport(flown, *other).run(rows), name, cpp ? "C99" : "the C++ header");
      seen += cpp ? "; C99 has the same bits as its deterministic policy"
                  : "; the C++ header's deterministic policy has the same bits";
    }
    seen += "\n";
  }
  return seen;
}

}  // namespace nlo::trainer
