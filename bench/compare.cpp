// SPDX-License-Identifier: MIT
// Tracks the ratios of the benchmarks; bench/run.sh measures them.
//   compare BEFORE.json NOW.json [--tolerance 0.1]   exit 1 when a ratio fell by more than that share, or is missing
//   compare --collect OUT.json RUN.json...           medians of the files that benchmarks wrote with --json
//   compare --table RESULT.json                      a result as Markdown
//   compare --write RESULT.json DOCUMENT.md          the same, into the document between its two marks
// Exit 2: wrong usage, or a file that cannot be read or has another format.
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "bench/tracking.h"

namespace {

using nlo::bench::Json;

constexpr char kUsage[] =
    "usage: compare BEFORE.json NOW.json [--tolerance 0.1]\n"
    "       compare --collect OUT.json RUN.json...\n"
    "       compare --table RESULT.json\n"
    "       compare --write RESULT.json DOCUMENT.md\n";

/// Ends the program with exit code 2.
struct Misuse : std::runtime_error {
  using std::runtime_error::runtime_error;
};

std::string read_file(const std::string& path) {
  std::ifstream file(path);
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (!file.is_open() || file.bad()) throw Misuse(path + ": cannot be read");
  return text;
}

Json read_json(const std::string& path) {
  try {
    return Json::parse(read_file(path));
  } catch (const Json::exception& error) {
    throw Misuse(path + ": " + error.what());
  }
}

void write_file(const std::string& path, const std::string& text) {
  const std::string unfinished = path + ".unfinished";
  {
    std::ofstream file(unfinished);
    file << text;
    if (!file.flush()) throw Misuse(unfinished + ": cannot be written");
  }
  std::filesystem::rename(unfinished, path);
}

int collect(const std::vector<std::string>& arguments) {
  std::vector<Json> runs;
  for (std::size_t i = 2; i < arguments.size(); ++i) runs.push_back(read_json(arguments[i]));
  const Json result = nlo::bench::collect(runs, nlo::bench::describe_machine());
  write_file(arguments[1], result.dump(2) + '\n');
  return 0;
}

int write_table(const std::string& result, const std::string& document) {
  constexpr std::string_view kBegin = "<!-- table -->\n", kEnd = "<!-- end of table -->";
  std::string text = read_file(document);
  const auto begin = text.find(kBegin), end = text.find(kEnd);
  if (begin == std::string::npos || end == std::string::npos || end < begin)
    throw Misuse(document + ": has no lines \"<!-- table -->\" and \"<!-- end of table -->\" to write between");
  const auto first = begin + kBegin.size();
  write_file(document, text.replace(first, end - first, '\n' + nlo::bench::markdown(read_json(result)) + '\n'));
  return 0;
}

int compare(const std::string& before, const std::string& now, double tolerance) {
  const nlo::bench::Comparison result = nlo::bench::compare(read_json(before), read_json(now), tolerance);
  std::printf("%s", result.table.c_str());
  if (!result.differences.empty()) std::printf("\nnot the same\n%s", result.differences.c_str());
  if (result.fallen + result.missing == 0) return 0;
  std::printf("\n%d fell by more than %g %%, %d missing\n", result.fallen, 100.0 * tolerance, result.missing);
  return 1;
}

int run(const std::vector<std::string>& arguments) {
  const std::size_t count = arguments.size();
  if (count >= 3 && arguments[0] == "--collect") return collect(arguments);
  if (count == 3 && arguments[0] == "--write") return write_table(arguments[1], arguments[2]);
  if (count == 2 && arguments[0] == "--table") {
    std::printf("%s", nlo::bench::markdown(read_json(arguments[1])).c_str());
    return 0;
  }
  double tolerance = 0.1;
  if (count == 4 && arguments[2] == "--tolerance") {
    const std::string& text = arguments[3];
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), tolerance);
    if (error != std::errc{} || end != text.data() + text.size() || !(tolerance >= 0.0 && tolerance < 1.0))
      throw Misuse("--tolerance is a share from 0 to 1, e.g. 0.1 for 10 %");
  } else if (count != 2) {
    throw Misuse(kUsage);
  }
  return compare(arguments[0], arguments[1], tolerance);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run({argv + 1, argv + argc});
  } catch (const std::exception& error) {  // also from a result without a necessary entry
    std::fprintf(stderr, "compare: %s\n", error.what());
    return 2;
  }
}
