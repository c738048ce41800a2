// SPDX-License-Identifier: MIT
#include "tests/codegen/golden.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "codegen/base/file.h"

namespace nlo::codegen {

void expect_golden(const std::string& text, const std::string& file) {
  const std::string path = std::string(NLO_SOURCE_DIR "/tests/golden/") + file;
  if (const char* refresh = std::getenv("NLO_REFRESH_GOLDENS"); refresh != nullptr && *refresh == '1')
    write_file_atomically(path, text);
  std::istringstream want(std::filesystem::exists(path) ? read_file(path) : ""), got(text);
  int line = 1, shown = 0;
  for (std::string w, g; shown < 10; ++line) {
    const bool more_wanted = static_cast<bool>(std::getline(want, w)),
               more_got = static_cast<bool>(std::getline(got, g));
    if (!more_wanted && !more_got) break;
    if (more_wanted == more_got && w == g) continue;
    ++shown;
    ADD_FAILURE() << file << ":" << line << "\n- " << (more_wanted ? w : "(ends)") << "\n+ "
                  << (more_got ? g : "(ends)") << "\nmeant? NLO_REFRESH_GOLDENS=1 writes the new text";
  }
}

}  // namespace nlo::codegen
