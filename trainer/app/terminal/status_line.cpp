// SPDX-License-Identifier: MIT
#include "trainer/app/terminal/status_line.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdlib>
#include <string_view>
#include <utility>

namespace nlo::trainer {
namespace {

constexpr auto kRedrawEvery = std::chrono::milliseconds(100);

bool utf8_terminal() {
  for (const char* name : {"LC_ALL", "LC_CTYPE", "LANG"}) {  // the first one set decides, as in the C library
    const char* value = std::getenv(name);
    if (value == nullptr || *value == '\0') continue;
    const std::string_view text = value;
    return text.find("UTF-8") != text.npos || text.find("utf8") != text.npos || text.find("UTF8") != text.npos ||
           text.find("utf-8") != text.npos;
  }
  return false;
}

StatusLine::Mode mode_of(std::FILE* stream) {
  if (!isatty(fileno(stream))) return StatusLine::Mode::kLog;
  const char* terminal = std::getenv("TERM");
  const bool dumb = terminal == nullptr || std::string_view(terminal) == "dumb";
  return dumb ? StatusLine::Mode::kLog : StatusLine::Mode::kTerminal;
}

}  // namespace

StatusLine::StatusLine(std::FILE* stream) : StatusLine(stream, mode_of(stream), utf8_terminal()) {}

StatusLine::StatusLine(std::FILE* stream, Mode mode, bool utf8, std::size_t columns)
    : stream_(stream), mode_(mode), utf8_(utf8), fixed_columns_(columns) {}

StatusLine::~StatusLine() {
  finish();
}

std::size_t StatusLine::columns() const {
  if (fixed_columns_ > 0) return fixed_columns_;
  winsize size{};  // asked each time, because the window may be resized during a run
  if (ioctl(fileno(stream_), TIOCGWINSZ, &size) == 0 && size.ws_col > 1) return size.ws_col - std::size_t{1};
  return 79;
}

void StatusLine::draw() {
  // Writes the line from the first column, and erases the rest of a longer line.
  const std::string line = "\r" + latest_(columns(), utf8_) + "\x1b[K";
  std::fwrite(line.data(), 1, line.size(), stream_);
  std::fflush(stream_);
  open_ = true;
  stale_ = false;
}

void StatusLine::update(double share, bool last, BarText bar, const LogText& log) {
  if (mode_ == Mode::kSilent) return;
  const auto now = std::chrono::steady_clock::now();
  if (mode_ == Mode::kLog && now < log_from_) return;
  const bool first = !started_;
  started_ = true;
  if (mode_ == Mode::kTerminal) {
    latest_ = std::move(bar);
    stale_ = true;
    if (!first && !last && now - last_output_ < kRedrawEvery) return;
    draw();
  } else {
    const auto tenth = static_cast<long>(10.0 * share);
    if (!first && !last && tenth == last_logged_tenth_ && now - last_output_ < log_every_) return;
    last_logged_tenth_ = tenth;
    const std::string line = log(utf8_) + "\n";
    std::fwrite(line.data(), 1, line.size(), stream_);
    std::fflush(stream_);
  }
  last_output_ = now;
}

void StatusLine::finish() {
  if (!open_) return;
  if (stale_) draw();
  std::fputc('\n', stream_);
  std::fflush(stream_);
  open_ = false;
}

}  // namespace nlo::trainer
