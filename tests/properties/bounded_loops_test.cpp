// SPDX-License-Identifier: MIT
// No loop of the runtime or of generated C99 waits for data: each counts to or from a number that is a constant of the
// model or of the code. The test reads the source, so that a new loop must be reviewed.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <string_view>
#include <vector>

namespace {

namespace fs = std::filesystem;

const fs::path kRoot = NLO_SOURCE_DIR;

/// A loop without a counter, and the reason why it ends.
struct Exception {
  std::string_view file, text;
};
const std::vector<Exception> kExceptions = {
    // Loops over template arguments: they end during compilation, or the program does not compile.
    {"kernels/per_isa/vectors.inc", "while (lanes > 1 && values % lanes != 0) lanes /= 2;"},
    {"kernels/panels.h", "while (o >= tile_at(tile + 1)) ++tile;"},
    {"kernels/int16.h", "while (4 * fours(rows) > rows) ++rows;"},
    {"kernels/cortex_m.h", "while (one >= first(part) + size(part)) ++part;"},
    // Pointers through arrays of constant size, by constant strides.
    {"kernels/cortex_m.h", "while (out != large_end) multiply_block<B::kLarge, kFused, kIn>(weights, bias, in, out);"},
    {"kernels/cortex_m.h", "while (out != end) multiply_block<B::kSmall, kFused, kIn>(weights, bias, in, out);"},
    // Loops over texts and numbers of the program itself.
    {"selftest/NAME_selftest.c.in", "for (; *text != '\\0'; ++text) put_char(*text);"},
    {"selftest/NAME_selftest.c.in", "while ((value /= 10U) != 0U);"},
    // Loops over lists whose length the export fixes.
    {"ros2_control/src/observer_controller.cpp.in",
     "for (std::size_t i = 0; i < all.size(); ++i) interfaces.emplace_back(get_node()->get_name(), all[i], "
     "&exported_.at(i));"},
    {"fmu/sources/NAME_fmi3_values.c.in",
     "for (size_t e = 0; e < size_of(references[k]); ++e) { values[n++] = number_of(i, references[k], e); }"},
    // The main loops of programs.
    {"flight/replay.c.in", "while (fread(row, sizeof(row), 1, in) == 1) {"},
    {"zephyr/samples/NAME/src/main.cpp.in", "for (uint32_t steps = 0;; ++steps) {"},
};

/// Returns the code of a line without comments; for a source of the generator, the code that it writes.
std::string code_of(std::string line, bool generator = false) {
  if (generator) {
    const std::size_t from = line.find('"'), to = line.rfind('"');
    line = from < to && to != std::string::npos ? line.substr(from + 1, to - from - 1) : "";
  }
  line = line.substr(0, line.find("//"));
  return std::regex_replace(line, std::regex("^\\s+|\\s+$"), "");
}

/// A condition with a call may be unbounded, unless the condition also has a counter.
bool is_counted(const std::string& condition) {
  static const std::regex kCounter("\\w+ < (k|@|\\w+::k)\\w+"), kCall("\\w\\("),
      kSizes("((kernels::)?padded|sizeof)\\([^()]*\\)");
  if (condition.find_first_not_of(' ') == std::string::npos) return false;
  if (std::regex_search(condition, kCounter)) return true;
  return !std::regex_search(std::regex_replace(condition, kSizes, ""), kCall) &&
         condition.find_first_of("<>") != std::string::npos;
}

bool waits(const std::string& code) {
  static const std::regex kWaiting("\\b(while|goto)\\b|\\bdo \\{"), kFor("\\bfor \\(([^;]*);([^;]*);");
  std::smatch found;
  return std::regex_search(code, kWaiting) || (std::regex_search(code, found, kFor) && !is_counted(found[2]));
}

bool is_excepted(const std::string& path, const std::string& code) {
  return std::any_of(kExceptions.begin(), kExceptions.end(), [&](const Exception& e) {
    return path.size() >= e.file.size() && path.compare(path.size() - e.file.size(), e.file.size(), e.file) == 0 &&
           code == e.text;
  });
}

std::vector<std::string> waiting_loops(const fs::path& folder, std::size_t& loops) {
  std::vector<std::string> found;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kRoot / folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path());
    const bool prose = entry.path().string().find(".md") != std::string::npos;
    for (std::string line; !prose && std::getline(file, line);) {
      const std::string code = code_of(line, entry.path().extension() == ".cpp");
      loops += code.find("for (") != std::string::npos;
      if (waits(code) && !is_excepted(entry.path().string(), code))
        found.push_back(entry.path().string() + ": " + code);
    }
  }
  return found;
}

TEST(Loops, InTheRuntimeAndInGeneratedC99AreBounded) {
  std::size_t loops = 0;
  for (const char* folder : {"runtime/include/nlo", "codegen/targets"})
    for (const std::string& loop : waiting_loops(folder, loops))
      ADD_FAILURE() << loop << "\n  give it a counter and a bound, or say in this test why it ends";
  EXPECT_GT(loops, 200U) << "control: the loops were found";
}

TEST(Loops, ControlTheSearchFindsLoopsThatWait) {
  EXPECT_TRUE(waits("while (magnitude(w) > T(0.5)) {"));
  EXPECT_TRUE(waits("for (; magnitude(w) > T(0.5); ++doublings) w = w * T(0.5);"));
  EXPECT_TRUE(waits("for (;;) {"));
  EXPECT_TRUE(waits("do {"));
  EXPECT_FALSE(waits("for (; doublings < kMost && magnitude(w) > T(0.5); ++doublings) w = w * T(0.5);"));
  EXPECT_FALSE(waits("for (int i = kIn; i < kernels::padded(kIn); ++i) in[i] = Scalar(0);"));
  EXPECT_FALSE(waits("for (const Scalar value : z) good = good & is_below(value, Scalar(0x1p100));"));
}

}  // namespace
