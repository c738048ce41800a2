// SPDX-License-Identifier: MIT
// Reads a text file of the machine that emulates the board, by semihosting: numbers separated by commas, line by line.
#pragma once

#include <cstdlib>

namespace nlo::bench {

class HostFile {
 public:
  explicit HostFile(const char* name) {
    int length = 0;
    while (name[length] != '\0') ++length;
    const struct {
      const char* name;
      int mode, length;
    } request = {name, 0, length};
    file_ = call(kOpen, &request);
  }

  bool is_open() const { return file_ >= 0; }

  /// Skips the rest of the line. Returns false if the file ends before the line.
  bool skip_line() {
    int c = next();
    while (c != '\n' && c != kEnd) c = next();
    return c == '\n';
  }

  /// Reads at most `most` numbers of the next line and returns their count, 0 at the end of the file. Other text
  /// becomes -1.
  int read_line(float* numbers, int most) {
    char field[32];
    int length = 0, count = 0;
    for (int c = next(); c != kEnd; c = next()) {
      if (c != ',' && c != '\n') {
        if (length + 1 >= static_cast<int>(sizeof(field))) return -1;
        field[length++] = static_cast<char>(c);
        continue;
      }
      field[length] = '\0';
      char* end = nullptr;
      const float number = std::strtof(field, &end);
      if (length == 0 || *end != '\0' || count == most) return -1;
      numbers[count++] = number;
      length = 0;
      if (c == '\n') return count;
    }
    return length == 0 && count == 0 ? 0 : -1;
  }

 private:
  static constexpr int kOpen = 1, kRead = 6, kEnd = -1;

  /// Executes the breakpoint that the emulator handles: operation in r0, its argument in r1.
  static int call(int operation, const void* argument) {
    register int r0 __asm__("r0") = operation;
    register const void* r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
  }

  int next() {
    if (at_ == size_) {
      const struct {
        int file;
        char* buffer;
        int size;
      } request = {file_, buffer_, static_cast<int>(sizeof(buffer_))};
      // The call returns the number of missing bytes.
      size_ = static_cast<int>(sizeof(buffer_)) - call(kRead, &request);
      at_ = 0;
      if (size_ <= 0) return size_ = 0, kEnd;
    }
    return static_cast<unsigned char>(buffer_[at_++]);
  }

  int file_ = -1, at_ = 0, size_ = 0;
  char buffer_[4096] = {};
};

}  // namespace nlo::bench
