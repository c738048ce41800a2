// SPDX-License-Identifier: MIT
// An experiment file with --set options: a line "#--set SECTION.KEY=VALUE" becomes an option.
#include "trainer/experiments/load_experiment.h"

#include <vector>

#include "tests/fuzz/fuzz.h"

using namespace nlo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string_view text = fuzzing::text_of(bytes, size);
  std::vector<std::string> overrides;
  constexpr std::string_view kMark = "#--set ";
  for (std::size_t at = text.find(kMark); at != std::string_view::npos; at = text.find(kMark, at + 1)) {
    const std::size_t begin = at + kMark.size();
    overrides.emplace_back(text.substr(begin, text.find('\n', begin) - begin));
  }
  fuzzing::accepts([&] {
    const auto draft = trainer::parse_draft(text, "e.toml", overrides);
    if (!draft.complete) return;
    const std::string written = trainer::format_experiment(draft.experiment);
    const std::string again = trainer::format_experiment(trainer::parse_experiment(written, "written.toml"));
    fuzzing::require(again == written, "an experiment comes back as written");
  });
  return 0;
}
