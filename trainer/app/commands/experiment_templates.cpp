// SPDX-License-Identifier: MIT
#include "trainer/app/commands/experiment_templates.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "codegen/base/replaced.h"
#include "trainer/base/number_text.h"
#include "trainer/config/value.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {
namespace {

constexpr const char* kPlant =
    R"toml(# An experiment with a plant by equations: its motion, its sensors, and the start of its runs. Replace the pendulum
# by your plant. Lines that begin with "# " and a key are examples of further keys.
#   nlo train {file}                trains an observer on simulated runs and tests it
#   nlo simulate {file} -o run.csv  writes a run as a CSV file
#   nlo train --help-config         every key with its default
# Missing keys (eigenvalues, network, length of the training) are derived from the plant and its noise.
name = "{name}"

[plant]
states = ["angle", "rate"]        # the states of the equations
state_units = ["rad", "rad/s"]    # for reports
# dx/dt, an expression for each state:
derivative = ["rate", "-g / l * sin(angle) - damping * rate"]
output_names = ["angle_sensor"]   # what is measured,
outputs = ["angle"]               # an expression for each sensor
output_units = ["rad"]
parameters = { g = 9.81, l = 0.5, damping = 0.4 }
# Give a range to each parameter that you do not know exactly: l = [0.45, 0.55]. Each run draws a value, so that the
# observer also serves the real plant, and an observer with these equations inside (a prior) is tried, too.
# Which states are estimated, where not all are:
# estimated = ["rate"]
# Commands of a controller, which the observer knows. derivative contains their effect: "... + torque / (l * l)".
# inputs = ["torque"]
# input_units = ["N m/kg"]

[simulation]
horizon_s = 10.0                  # length of a run: longer than the transient of its start
sample_period_s = 0.02            # how often the observer is stepped in flight
trajectories = 100                # training runs, each from a state drawn from this box:
initial_low = [-1.0, -2.0]
initial_high = [1.0, 2.0]
# White noise on dx/dt, a standard deviation per sqrt(s) for each state: what your equations do not know.
# process_noise = [0.0, 0.05]

[training]
noise = "gaussian:0.02"           # noise of the sensors: standard deviation in their unit; a list has one for each

# With inputs: what they do in the runs, drawn for each.
# [excitation]
# kinds = ["steps", "multisine", "constant"]
# low = [-1.0]
# high = [1.0]

# A plant that is unstable without its controller: the loop it runs in.
# [feedback]
# law = ["-4 * rate + r_torque"]
# actuator_low = [-5.0]
# actuator_high = [5.0]
)toml";

/// Makes one line of comment from any text in the heading of a file.
std::string one_line(std::string text) {
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
  return text;
}

std::string key_line(const std::string& key, const std::string& value, const std::string& comment = "") {
  const std::string line = fmt::format("{} = {}", key, value);
  return comment.empty() ? line + "\n" : fmt::format("{:<30}  # {}\n", line, one_line(comment));
}

std::string range_text(const GuessedColumn& column) {
  if (column.low > column.high) return "";
  return fmt::format("{} to {}{}{}", significant(column.low), significant(column.high), column.unit.empty() ? "" : " ",
                     column.unit);
}

/// Returns the text of a column. `must_choose`: nothing can be trained until the user chooses the role of the column.
std::string column_text(const GuessedColumn& column, bool must_choose) {
  std::string text = "\n[[log.columns]]\n" + key_line("name", show_value(column.name), range_text(column));
  if (!column.heading.empty() && column.heading != column.name) text += key_line("column", show_value(column.heading));
  if (!column.is_decided)
    text += fmt::format(
        "# {} its role: \"output\" (a sensor gives it in flight), \"input\" (a controller commands or knows it), "
        "\"state\"\n"
        "# (the truth that is to be estimated: only this log has it), or \"ignored\".\n",
        must_choose ? kChoose : "CHECK");
  const bool is_open = !column.is_decided && must_choose;
  text += key_line("role", show_value(is_open ? std::string(kChoose) : std::string(to_name(column.role))), column.why);
  if (!column.unit.empty()) text += key_line("unit", show_value(column.unit));
  if (!column.missing.empty())
    text += key_line("missing", show_cells(column.missing), "CHECK: delete this key if these values are readings");
  if (column.role == ColumnRole::kOutput && column.period_s > 0.0)
    text += key_line("period_s", fmt::format("{:.4g}", column.period_s),
                     fmt::format("it has a value in one of {} rows", column.spacing));
  if (!column.derivative_of.empty()) text += key_line("derivative_of", show_value(column.derivative_of));
  // An input that does not jump gets no `wrap`: it may have end stops within one turn.
  if (column.wrap == 0.0 || column.role == ColumnRole::kIgnored) return text;
  if (column.role == ColumnRole::kInput && !column.jumps) return text;
  text += key_line("wrap", show_wrap(column.wrap),
                   column.jumps ? "it jumps by a full turn"
                                : "CHECK: no log shows a jump, but unit and range suggest an angle that wraps; delete "
                                  "both lines if it has end stops");
  if (column.role != ColumnRole::kInput)
    text += key_line("encoding", "\"sincos\"", "an angle without jumps: sine and cosine");
  return text;
}

std::string clock_lines(const GuessedClock& clock) {
  if (clock.heading.empty())
    return clock.period_s > 0.0 ? key_line("sample_period_s", shortest_text(clock.period_s),
                                           "time between rows, because no column is a time")
                                : key_line("sample_period_s", show_value(std::string(kChoose)),
                                           "no column is a time: write the time between rows in seconds");
  return fmt::format("# The period between samples follows from the stamps: {} s, {}; {} s in all.\n",
                     significant(clock.period_s), evenness_text(clock), significant(clock.duration_s));
}

std::string filter_text(const GuessedLog& log) {
  const bool derived =
      std::ranges::any_of(log.columns, [](const GuessedColumn& c) { return !c.derivative_of.empty(); });
  constexpr double kUsual_hz = 25.0, kShare = 0.2;  // kShare: cut-off as a share of the sample rate
  if (!derived || log.clock.period_s == 0.0 || kShare / log.clock.period_s >= kUsual_hz) return "";
  return "\n[log.velocity_filter]\n" + key_line("cutoff_hz", significant(kShare / log.clock.period_s, 2),
                                                "cut-off of the filter for rates that are computed from the log");
}

}  // namespace

std::string files_text(std::size_t count) {
  return count == 0 ? "no file" : fmt::format("{} file{}", count, count == 1 ? "" : "s");
}

std::string evenness_text(const GuessedClock& clock) {
  constexpr double kEven = 0.1;  // the tolerance of the log loader
  return clock.deviation <= kEven ? "even" : fmt::format("uneven by up to {} periods", significant(clock.deviation, 2));
}

std::string plant_template(const std::string& name, const std::string& file) {
  return codegen::replaced(codegen::replaced(kPlant, "{name}", name), "{file}", one_line(file));
}

std::string log_template(const GuessedLog& log, const std::string& name, const std::string& command,
                         const std::string& train) {
  std::string text = fmt::format(
      "# Written by: {}\n# Guessed from headings and numbers; the reason follows each role. Look for CHECK and CHOOSE, "
      "then:\n"
      "#   {}\n# Missing keys (eigenvalues, network, length of the training) are derived from the logs; every key with "
      "its\n"
      "# default: nlo train --help-config\nname = \"{}\"\n\n[log]\n",
      one_line(command), one_line(train), name);
  text += clock_lines(log.clock);
  if (log.format.separator != ',')
    text += key_line("separator", show_value(std::string(log.format.separator == '\t'  ? "tab"
                                                         : log.format.separator == ' ' ? "space"
                                                                                       : ";")));
  if (log.format.decimal != '.') text += key_line("decimal", show_value(std::string(1, log.format.decimal)));
  text += key_line("train_files", show_value(log.train));
  if (log.validation.empty())
    text +=
        "# With logs of more runs, add validation_files = [\"...\"], which choose the model, and test it on "
        "others\n"
        "# (test_files = [\"...\"]).\n";
  else
    text += key_line("validation_files", show_value(log.validation), "chooses the model");
  if (!log.test.empty()) text += key_line("test_files", show_value(log.test), "judges it");
  for (const std::string& note : log.notes) text += fmt::format("# note: {}\n", one_line(note));
  text += filter_text(log);
  if (!log.clock.heading.empty()) {
    text += "\n[[log.columns]]\n" + key_line("name", "\"time\"");
    if (log.clock.heading != "time") text += key_line("column", show_value(log.clock.heading));
    text += key_line("role", "\"time\"", log.clock.why) + key_line("unit", show_value(log.clock.unit));
  }
  const bool must_choose = log.count(ColumnRole::kOutput) == 0 || log.count(ColumnRole::kState) == 0;
  for (const GuessedColumn& column : log.columns)
    if (column.role != ColumnRole::kIgnored || !column.is_decided) text += column_text(column, must_choose);
  std::string ignored;
  for (const GuessedColumn& column : log.columns)
    if (column.role == ColumnRole::kIgnored && column.is_decided)
      ignored += fmt::format("#   {}: {}\n", one_line(column.heading), one_line(column.why));
  return ignored.empty() ? text : text + "\n# Not read:\n" + ignored;
}

}  // namespace nlo::trainer
