// SPDX-License-Identifier: MIT
#include "trainer/data/training_logs.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <limits>

#include "codegen/base/error.h"
#include "codegen/base/splitmix.h"
#include "trainer/base/number_text.h"
#include "trainer/base/printable.h"

namespace nlo::trainer {
namespace {

constexpr std::size_t kSketch = 16;

/// Removes the text before the next `separator`, or the whole text, from the front and returns it.
std::string_view take(std::string_view& text, char separator) {
  const std::size_t end = std::min(text.find(separator), text.size());
  const std::string_view part = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return part;
}

template <typename Number, typename... Base>
Number number(std::string_view text, Base... base) {
  Number value{};
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value, base...);
  if (status != std::errc() || end != text.data() + text.size())
    throw codegen::Error(fmt::format("provenance.{}: \"{}\" is not a number; train the model again", kTrainingLogsFact,
                                     text.substr(0, 40)));
  return value;
}

}  // namespace

TrainingLogs remember(const std::vector<LogContent>& contents, const Dataset& training) {
  TrainingLogs result;
  for (const LogContent& content : contents) {
    const auto count = static_cast<std::ptrdiff_t>(std::min(kSketch, content.windows.size()));
    // A fact of a model is UTF-8 text in lines, but names of files may have any bytes.
    result.logs.push_back(
        {ascii(content.name), content.rows, {content.windows.begin(), content.windows.begin() + count}});
  }
  if (training.trajectories.empty()) return result;
  const auto ny = static_cast<Eigen::Index>(training.outputs.size());
  Eigen::VectorXd low = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(training.readings().size()),
                                                  std::numeric_limits<double>::infinity());
  Eigen::VectorXd high = -low;
  const auto look_at = [&](Eigen::Index first, const Eigen::MatrixXd& signal) {
    low.segment(first, signal.rows()) = low.segment(first, signal.rows()).cwiseMin(signal.rowwise().minCoeff());
    high.segment(first, signal.rows()) = high.segment(first, signal.rows()).cwiseMax(signal.rowwise().maxCoeff());
  };
  for (const Trajectory& run : training.trajectories) {
    look_at(0, run.outputs);
    if (training.reads_inputs) look_at(ny, run.inputs);
  }
  widen_by_mirror(training.mirror, low, high);
  for (Eigen::Index j = 0; j < ny; ++j)
    if (const Channel& output = training.outputs[static_cast<std::size_t>(j)]; output.wrap == 0.0)
      result.outputs.push_back({output.name, low(j), high(j)});
  return result;
}

std::string to_text(const TrainingLogs& logs) {
  std::string text;
  for (const TrainingLogs::Range& range : logs.outputs)
    text += fmt::format("output {} {} {}\n", shortest_text(range.low), shortest_text(range.high), range.output);
  for (const TrainingLogs::Log& log : logs.logs) {
    text += fmt::format("log {} ", log.rows);
    for (const std::uint64_t hash : log.sketch) text += fmt::format("{:x},", hash);
    text += fmt::format(" {}\n", log.name);
  }
  return text;
}

TrainingLogs parse_training_logs(std::string_view text) {
  TrainingLogs result;
  while (!text.empty()) {
    std::string_view line = take(text, '\n');
    const std::string_view kind = take(line, ' ');
    if (kind == "output") {
      TrainingLogs::Range range;
      range.low = number<double>(take(line, ' '));
      range.high = number<double>(take(line, ' '));
      range.output = line;
      result.outputs.push_back(std::move(range));
    } else if (kind == "log") {
      TrainingLogs::Log log;
      log.rows = number<Eigen::Index>(take(line, ' '));
      for (std::string_view hashes = take(line, ' '); !hashes.empty();)
        log.sketch.push_back(number<std::uint64_t>(take(hashes, ','), 16));
      log.name = line;
      result.logs.push_back(std::move(log));
    } else {
      throw codegen::Error(
          fmt::format("provenance.{}: a line begins with \"{}\"; expected output or log: train the "
                      "model again",
                      kTrainingLogsFact, kind.substr(0, 40)));
    }
  }
  return result;
}

void note_rows_of_training(const TrainingLogs& training, const std::vector<LogContent>& contents,
                           std::vector<std::string>& notes) {
  for (const LogContent& content : contents)
    for (const TrainingLogs::Log& log : training.logs)
      if (const double share = share_found(log.sketch, content.windows); share > 0.0)
        notes.push_back(
            fmt::format("{}: it contains about {:.0f} % of the training log {} of this model, so its errors here are "
                        "training errors; evaluate on a log that training has not seen",
                        content.name, 100.0 * share, log.name));
}

void note_outputs_beyond(const TrainingLogs& training, const Dataset& logs, std::vector<std::string>& notes) {
  for (const TrainingLogs::Range& range : training.outputs) {
    const auto output = std::find_if(logs.outputs.begin(), logs.outputs.end(),
                                     [&](const codegen::Channel& channel) { return channel.name == range.output; });
    if (output == logs.outputs.end() || !(range.high > range.low)) continue;
    const double allowed = kBeyondRange * (range.high - range.low);
    Eigen::Index outside = 0, samples = 0;
    double worst = 0.0;
    std::string where;
    for (const Trajectory& run : logs.trajectories) {
      const Eigen::ArrayXd y = run.outputs.row(output - logs.outputs.begin()).transpose().array();
      const Eigen::ArrayXd beyond = (range.low - y).max(y - range.high);
      outside += (beyond > allowed).count();
      samples += y.size();
      if (beyond.maxCoeff() <= worst) continue;
      worst = beyond.maxCoeff();
      where = run.source;
    }
    if (outside == 0) continue;
    const std::string unit = output->unit.empty() ? "" : " " + output->unit;
    notes.push_back(
        fmt::format("{}: output \"{}\" leaves its training range, {:.4g} to {:.4g}{}, by up to {:.3g}{}; "
                    "{:.3g} % of the samples of these logs are outside: unless T* reads it only as z - y, "
                    "estimates there are extrapolated; train on logs that cover this range",
                    where, range.output, range.low, range.high, unit, worst, unit,
                    100.0 * static_cast<double>(outside) / static_cast<double>(samples)));
  }
}

namespace {

using Eigen::Index;

std::vector<std::uint64_t> row_hashes(const LogFile& log, const std::vector<std::string>& headings) {
  std::vector<std::uint64_t> hashes(static_cast<std::size_t>(log.time_s.size()), 0);
  for (const std::string& heading : headings) {
    const Eigen::VectorXd& values = log.column(heading);
    // Adding 0.0 turns -0 into 0, because a file may write either for the same value.
    for (std::size_t k = 0; k < hashes.size(); ++k)
      hashes[k] = codegen::mixed(hashes[k] + 0x9e3779b97f4a7c15u +
                                 std::bit_cast<std::uint64_t>(values[static_cast<Index>(k)] + 0.0));
  }
  return hashes;
}

}  // namespace

LogContent content_of(const LogFile& log, const std::vector<std::string>& headings) {
  LogContent content{log.name, log.time_s.size(), {}};
  if (content.rows < kContentWindow) return content;
  const std::vector<std::uint64_t> rows = row_hashes(log, headings);
  constexpr auto kWindow = static_cast<std::size_t>(kContentWindow);
  // A rolling hash: a polynomial in an odd base, modulo 2^64. Each further window costs one row.
  constexpr std::uint64_t kBase = 0xd6e8feb86659fd93u;
  std::uint64_t leaving = 1;
  for (std::size_t i = 0; i < kWindow; ++i) leaving *= kBase;
  std::uint64_t hash = 0;
  std::size_t changes = 0;  // rows of the window, except the first, that differ from the row before
  for (std::size_t k = 0; k < rows.size(); ++k) {
    hash = hash * kBase + rows[k] - (k >= kWindow ? leaving * rows[k - kWindow] : 0);
    if (k > 0 && rows[k] != rows[k - 1]) ++changes;
    if (k >= kWindow && rows[k - kWindow + 1] != rows[k - kWindow]) --changes;
    if (k + 1 >= kWindow && changes >= kWindow / 2) content.windows.push_back(codegen::mixed(hash));
  }
  std::sort(content.windows.begin(), content.windows.end());
  content.windows.erase(std::unique(content.windows.begin(), content.windows.end()), content.windows.end());
  return content;
}

double share_found(const std::vector<std::uint64_t>& part, const std::vector<std::uint64_t>& whole) {
  if (part.empty()) return 0.0;
  const auto found = std::count_if(part.begin(), part.end(), [&](std::uint64_t hash) {
    return std::binary_search(whole.begin(), whole.end(), hash);
  });
  return static_cast<double>(found) / static_cast<double>(part.size());
}

void note_shared_rows(const std::vector<LogContent>& training, const std::vector<LogContent>& logs,
                      const std::string& split, std::vector<std::string>& notes) {
  for (const LogContent& log : logs)
    for (const LogContent& trained : training)
      if (const double share = share_found(log.windows, trained.windows); share > 0.0)
        notes.push_back(
            fmt::format("{}: {:.3g} % of its moving rows are also in the training log {}: it is a copy or a part of "
                        "that log, so its errors are training errors; remove it from {}_files",
                        log.name, 100.0 * share, trained.name, split));
}

}  // namespace nlo::trainer
