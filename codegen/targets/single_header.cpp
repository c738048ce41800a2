// SPDX-License-Identifier: MIT
#include "codegen/targets/single_header.h"

#include <fmt/format.h>

#include <cctype>
#include <map>
#include <string_view>

#include "codegen/base/embedded_text.h"
#include "codegen/base/number.h"
#include "codegen/targets/c99.h"

namespace nlo::codegen {
namespace {

/// Stands for NAME in the C99 templates, so that a name of the user cannot equal a name of the templates.
constexpr std::string_view kSelf = "SELF";

std::string word_in_cpp20(const std::string& word) {
  static const std::map<std::string, std::string> words = {
      {"IN_FLASH", ""},
      {"REGULAR_STEP", "&kStep"},
      {"load", "copy"},  // flash is ordinary memory
      {"SELF_observer", "State"},
      {"SELF_status", "Status"},
      {"SELF_OK", "Status::kOk"},
      {"SELF_CLAMPED", "Status::kClamped"},
      {"SELF_HELD", "Status::kHeld"},
      {"SELF_STALE", "Status::kStale"},
      {"SELF_OUT_OF_RANGE", "Status::kOutOfRange"},
      {"SELF_REJECTED", "Status::kRejected"},
      {"SELF_DIVERGED", "Status::kDiverged"},
      {"SELF_RESET", "Status::kReset"},
      {"SELF_alarm", "Alarm"},
      {"SELF_NO_ALARM", "Alarm::kNone"},
      {"SELF_INNOVATION_MEAN", "Alarm::kInnovationMean"},
      {"SELF_INNOVATION_VARIANCE", "Alarm::kInnovationVariance"},
      {"SELF_INNOVATION_CORRELATION", "Alarm::kInnovationCorrelation"},
      {"SELF_LATENT_DISTANCE", "Alarm::kLatentDistance"},
      {"SELF_MISSING", "Alarm::kMissing"},
      {"SELF_DISAGREEMENT", "Alarm::kDisagreement"},
      {"SELF_MONITOR_RESET", "Alarm::kReset"},
      {"SELF_averages", "Averages"},
      {"SELF_watched", "Watched"},
      {"SELF_monitor", "MonitorState"},
      {"EACH_STORE", "volatile"},
  };
  if (const auto found = words.find(word); found != words.end()) return found->second;
  if (word.starts_with("SELF_")) return word.substr(kSelf.size() + 1);
  const bool integer = word.ends_with("_t") && (word.starts_with("int") || word.starts_with("uint"));
  return integer ? "std::" + word : word;
}

std::string words_in_cpp20(std::string_view line) {
  const auto of_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  std::string text;
  for (std::size_t i = 0; i < line.size();) {
    std::size_t end = i;
    while (end < line.size() && of_word(line[end])) ++end;
    if (end == i) {
      text += line[i++];
      continue;
    }
    const std::string word = word_in_cpp20(std::string(line.substr(i, end - i)));
    text += word;
    i = word.empty() ? end + 1 : end;  // also removes the space behind it
  }
  return text;
}

/// Converts the generated C to C++20:
///   static, static const, enum { kN = 1 };   inline, inline constexpr, inline constexpr int kN = 1;
///   typedef struct { } T;  typedef enum { }  struct T { };  enum class T { };
///   NAME_step, NAME_OK, uint8_t              step, Status::kOk, std::uint8_t
std::string in_cpp20(std::string_view c) {
  constexpr std::string_view kStruct = "typedef struct {", kEnum = "typedef enum {", kSize = "enum { k";
  constexpr std::size_t kWidth = 120;
  std::string text, type, before;
  const auto replace = [](std::string& line, std::string_view from, std::string_view to) {
    const std::size_t at = line.find_first_not_of(' ');
    const bool found = at != std::string::npos && std::string_view(line).substr(at).starts_with(from);
    if (found) line.replace(at, from.size(), to);
    return found;
  };
  while (!c.empty()) {
    const std::size_t end = c.find('\n');
    std::string line(c.substr(0, end));
    c.remove_prefix(end == std::string_view::npos ? c.size() : end + 1);
    if (line == kStruct || line == kEnum) {
      const std::size_t at = c.find("\n} ") + 3;
      type = c.substr(at, c.find(';', at) - at);
      line = line == kStruct ? "struct " + type + " {" : "enum class " + type + " : uint8_t {";
    } else if (!type.empty() && line == "} " + type + ";") {
      line = "};";
      type.clear();
    } else if (replace(line, kSize, "inline constexpr int k")) {
      line.erase(line.find(" }"), 2);
    } else if (line.starts_with(' ')) {
      replace(line, "static const ", "static constexpr ");
    } else if (!replace(line, "static const ", "inline constexpr ") && !replace(line, "static ", "inline ") &&
               !line.starts_with("//") && line.find(" SELF_") == line.find(' ') &&
               line.find('(') != std::string::npos) {
      line = "inline " + line;
    }
    line = words_in_cpp20(line);
    for (const char* scope : {"Status::", "Alarm::"})
      if (!type.empty()) replace(line, scope, "");  // the declaration of an enumerator has no scope
    const std::size_t indent = line.find_first_not_of(' ');
    if (before.starts_with("inline ") && before.ends_with(',') && before.size() + 1 + line.size() - indent <= kWidth) {
      text.back() = ' ';  // without IN_FLASH the signature fits on one line
      line.erase(0, indent);
    }
    text += line + "\n";
    before = line;
  }
  return text;
}

std::string example(const Model& m, const std::string& name) {
  const auto calls = [](const std::vector<Channel>& channels, const char* verb) {
    std::string text;
    for (const Channel& channel : channels)
      text += fmt::format("{}{}_{}()", text.empty() ? "" : ", ", verb, channel.name);
    return "{" + text + "}";
  };
  return fmt::format(
      "// Use\n"
      "//   #include \"{0}.h\"\n"
      "//   using namespace nlo::single::{0};\n"
      "//   Observer observer;\n"
      "//\n"
      "//   void on_timer() {{  // every {1} s\n"
      "//     const Status s = observer.step({2}{3});\n"
      "//     if (s != Status::kOk) note_fault(s);  // kClamped, kHeld: usable for a while\n"
      "//     if (s >= Status::kStale) return enter_safe_mode();  // also kOutOfRange\n"
      "//     if (!observer.in_domain()) return enter_safe_mode();\n"
      "//     use(observer.estimate()[state_{4}]);\n"
      "//   }}\n",
      name, rounded_text(m.sample_period_s), calls(measured_channels(m), "read"),
      m.nu() == 0 ? "" : ", " + calls(inputs(m), "command"), m.states.front().name);
}

}  // namespace

std::string single_header(const PreparedExport& given) {
  const PreparedExport prepared = for_c99(given, "single");
  const Model& m = prepared.model();
  std::map<std::string, std::string> values = c99_values(prepared, std::string(kSelf));
  values["FOURS"] = values["INTEGER_FOURS"] = values["REST"] = values["C99"] = "";
  const auto part = [&values](std::string_view text) { return in_cpp20(filled(filled(text, values), values)); };
  values["SIZES"] = part("enum { kNx = @NX@, kNy = @NY@, kNz = @NZ@@MORE_SIZES@ };\n");
  const std::string types = part(embedded_text("c99/types.h.in")), body = part(embedded_text("c99/body.c.in"));
  const bool driven = m.nu() > 0;
  values["TYPES"] = types;
  values["BODY"] = body;
  values["WATCHED"] = m.monitor ? "true" : "";
  for (const char* text : {"MONITOR", "MONITOR_BODY"}) values[text] = part(values[text]);
  values["NAME"] = prepared.name();
  values["BITS"] = "std::" + values["BITS"];
  values["INPUT_TYPE"] = driven ? "  using Input = std::array<Scalar, kNu>;\n" : "";
  values["ONLY_U"] = driven ? "const Input& u" : "";
  values["U"] = driven ? ", const Input& u" : "";
  values["U_DATA"] = driven ? ", u.data()" : "";
  if (driven) values["INPUT_NOTE"].insert(0, "  ");
  values["WARM_START_METHOD"] =
      values["WARM_START"].empty()
          ? ""
          : fmt::format(
                "  // Starts from the steady state of y: a shorter transient when the plant is at rest, or after a "
                "gap.\n"
                "  [[nodiscard]] Status warm_start(const Output& y{}) {{ return detail::warm_start(&state_, "
                "y.data(){}); }}\n\n",
                values["START_U"].empty() ? "" : values["U"], values["START_U"].empty() ? "" : values["U_DATA"]);
  values["STALENESS_METHOD"] =
      values["STALENESS"].empty()
          ? ""
          : "  // How stale an output is that may be missing: 0 while it is measured, towards 1 the longer it is not.\n"
            "  [[nodiscard]] Scalar staleness(int output) const { return detail::staleness(&state_, output); }\n\n";
  values["TOP"] = c99_top(prepared, "one C++20 header to read through", "single", example(m, prepared.name()));
  return filled(embedded_text("single/observer.h.in"), values);
}

}  // namespace nlo::codegen
