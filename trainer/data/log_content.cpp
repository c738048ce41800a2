// SPDX-License-Identifier: MIT
#include "trainer/data/log_content.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "codegen/base/splitmix.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;

std::vector<std::uint64_t> row_hashes(const LogFile& log, const std::vector<std::string>& headings) {
  std::vector<std::uint64_t> hashes(static_cast<std::size_t>(log.time_s.size()), 0);
  for (const std::string& heading : headings) {
    const Eigen::VectorXd& values = log.column(heading);
    // + 0.0: a file may write -0 for 0.
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
  // A polynomial in an odd base, modulo 2^64, rolls: each window costs one row.
  constexpr std::uint64_t kBase = 0xd6e8feb86659fd93u;
  std::uint64_t leaving = 1;
  for (std::size_t i = 0; i < kWindow; ++i) leaving *= kBase;
  std::uint64_t hash = 0;
  std::size_t changes = 0;  // rows of the window that differ from the one before, its first left out
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
            fmt::format("{}: {:.3g} % of its moving rows stand in the training log {} too: a copy or a cut "
                        "of it, whose errors are those of training; take it out of {}_files",
                        log.name, 100.0 * share, trained.name, split));
}

}  // namespace nlo::trainer
