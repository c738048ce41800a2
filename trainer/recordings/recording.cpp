// SPDX-License-Identifier: MIT
#include "trainer/recordings/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <string_view>

#include "codegen/base/error.h"

namespace nlo::trainer {
namespace {

/// `count` bytes at `at` as a whole number; 0 where the file ends before.
std::uint64_t whole_number(std::ifstream& file, std::uint64_t at, int count, bool little) {
  unsigned char bytes[8] = {};
  file.seekg(static_cast<std::streamoff>(at));
  if (!file.read(reinterpret_cast<char*>(bytes), count)) return file.clear(), 0;
  std::uint64_t number = 0;
  for (int i = 0; i < count; ++i) number = number << 8 | bytes[little ? count - 1 - i : i];
  return number;
}

// How long a file must be, as its own headers say. Neither library sees that the end is missing: it reads zeros.

/// Up to version 7: variables behind each other, a tag with its length before each.
std::uint64_t length_of_mat_file(std::ifstream& file, std::uint64_t length) {
  constexpr std::uint64_t kHeader = 128, kTag = 8;
  const bool little = whole_number(file, kHeader - 2, 1, true) == 'I';
  if (whole_number(file, kHeader - 4, 2, little) != 0x100) return 0;  // 7.3 is HDF5, which looks itself
  std::uint64_t at = kHeader;
  while (at < length) at += kTag + whole_number(file, at + 4, 4, little);
  return at;
}

std::uint64_t length_of_database(std::ifstream& file, std::uint64_t) {
  const std::uint64_t page = whole_number(file, 16, 2, false);
  return (page == 1 ? 65536 : page) * whole_number(file, 28, 4, false);
}

/// A kind of recording. A new one is a line here.
struct RecordingKind {
  std::string_view first_bytes, ending;
  Recording (*read)(const std::string&, const WantedColumns&);  ///< null: told to be another one, by `fix`
  std::string_view fix;
  std::uint64_t (*needed_length)(std::ifstream& file, std::uint64_t length) = nullptr;  ///< 0: it does not say
};

constexpr std::array kKinds = {
    RecordingKind{"MATLAB ", ".mat", read_mat_file, "", length_of_mat_file},
    RecordingKind{std::string_view("SQLite format 3\0", 16), ".db3", read_rosbag, "", length_of_database},
    RecordingKind{"\x89MCAP0\r\n", ".mcap", nullptr,
                  "is an MCAP file: ros2 bag convert writes it as SQLite (storage_id: sqlite3)"},
    RecordingKind{"#ROSBAG V", ".bag", nullptr, "is a bag of ROS 1: rosbags-convert makes one of ROS 2 of it"},
    RecordingKind{"\x28\xB5\x2F\xFD", ".zstd", nullptr, "is compressed: zstd -d, then take the .db3 file"},
};

const RecordingKind* kind_of(const std::string& path) {
  std::array<char, 16> bytes{};
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), bytes.size());
  const std::string_view start(bytes.data(), static_cast<std::size_t>(file.gcount()));
  for (const RecordingKind& kind : kKinds)
    if (start.starts_with(kind.first_bytes)) return &kind;
  for (const RecordingKind& kind : kKinds)
    if (path.ends_with(kind.ending)) return &kind;
  return nullptr;
}

}  // namespace

bool is_recording(const std::string& path) {
  return kind_of(path) != nullptr;
}

Recording read_recording(const std::string& path, const WantedColumns& wanted) {
  const RecordingKind* kind = kind_of(path);
  if (kind == nullptr) throw codegen::Error(fmt::format("{}: is not a recording that nlo reads", path));
  if (kind->read == nullptr) throw codegen::Error(fmt::format("{}: {}", path, kind->fix));
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const auto length = static_cast<std::uint64_t>(std::max<std::streamoff>(file.tellg(), 0));
  if (const std::uint64_t needed = kind->needed_length(file, length); needed > length)
    throw codegen::Error(fmt::format("{}: has {} bytes, and needs {}: it was not copied whole, or is still written",
                                     path, length, needed));
  return kind->read(path, wanted);
}

}  // namespace nlo::trainer
