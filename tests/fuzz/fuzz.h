// SPDX-License-Identifier: MIT
// Common code of fuzz targets: an input is either accepted, or refused by an Error with a reason. Any other exception
// ends the program, as a finding of a sanitizer does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

#include "codegen/base/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);

namespace nlo::fuzzing {

inline std::string_view text_of(const std::uint8_t* bytes, std::size_t size) {
  return {reinterpret_cast<const char*>(bytes), size};
}

/// Returns true if `work` finished, false if it refused its input.
template <class Work>
bool accepts(const Work& work) {
  try {
    work();
    return true;
  } catch (const codegen::Error& error) {
    if (std::strlen(error.what()) == 0) std::abort();
    return false;
  }
}

/// Ends the program with a message, unless `holds`.
inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "property violated: %s\n", what);
  std::abort();
}

/// The text before the line `mark` and the text after it. Without such a line, all text is before it.
struct Parts {
  std::string_view before, after;
};
inline Parts split_at(std::string_view text, std::string_view mark) {
  const auto at = text.find(mark);
  if (at == std::string_view::npos) return {text, {}};
  return {text.substr(0, at), text.substr(at + mark.size())};
}

}  // namespace nlo::fuzzing
