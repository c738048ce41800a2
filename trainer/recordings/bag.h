// SPDX-License-Identifier: MIT
// A bag of ROS 2 as its tables in SQLite: topics, messages, and definitions of their types. Included where SQLite is.
#pragma once

#include <fmt/format.h>
#include <sqlite3.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "codegen/base/error.h"
#include "trainer/recordings/message_types.h"
#include "trainer/recordings/shared_library.h"

namespace nlo::trainer {

/// What is used of SQLite.
struct Sqlite {
  explicit Sqlite(const std::string& file) : library(NLO_SQLITE, file) {}
  SharedLibrary library;
  decltype(&sqlite3_bind_int64) bind_int64 = library.find<decltype(sqlite3_bind_int64)>("sqlite3_bind_int64");
  decltype(&sqlite3_close) close = library.find<decltype(sqlite3_close)>("sqlite3_close");
  decltype(&sqlite3_column_blob) column_blob = library.find<decltype(sqlite3_column_blob)>("sqlite3_column_blob");
  decltype(&sqlite3_column_bytes) column_bytes = library.find<decltype(sqlite3_column_bytes)>("sqlite3_column_bytes");
  decltype(&sqlite3_column_int64) column_int64 = library.find<decltype(sqlite3_column_int64)>("sqlite3_column_int64");
  decltype(&sqlite3_errmsg) errmsg = library.find<decltype(sqlite3_errmsg)>("sqlite3_errmsg");
  decltype(&sqlite3_finalize) finalize = library.find<decltype(sqlite3_finalize)>("sqlite3_finalize");
  decltype(&sqlite3_open_v2) open_v2 = library.find<decltype(sqlite3_open_v2)>("sqlite3_open_v2");
  decltype(&sqlite3_prepare_v2) prepare_v2 = library.find<decltype(sqlite3_prepare_v2)>("sqlite3_prepare_v2");
  decltype(&sqlite3_step) step = library.find<decltype(sqlite3_step)>("sqlite3_step");
};

inline const Sqlite& sqlite(const std::string& file = "") {
  static const Sqlite loaded(file);
  return loaded;
}

struct Topic {
  std::int64_t id = 0;
  std::string name, type;
};

class Bag {
 public:
  explicit Bag(const std::string& path) : path_(path) {
    sqlite3* opened = nullptr;
    const int status = sqlite(path).open_v2(path.c_str(), &opened, SQLITE_OPEN_READONLY, nullptr);
    database_.reset(opened);
    if (status != SQLITE_OK) fail();
    if (!has_table("topics") || !has_table("messages"))
      throw codegen::Error(fmt::format(
          "{}: is an SQLite file without the tables of a rosbag2: expected a .db3 of ros2 bag record", path));
    query("SELECT id, name, type, serialization_format FROM topics", [&](sqlite3_stmt* row) {
      topics_.push_back({sqlite().column_int64(row, 0), text(row, 1), text(row, 2)});
      if (text(row, 3) != "cdr")
        throw codegen::Error(fmt::format("{}: {} is serialised as \"{}\": expected cdr; ros2 bag convert writes it",
                                         path_, topics_.back().name, text(row, 3)));
    });
    if (has_table("message_definitions"))
      query("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions", [&](sqlite3_stmt* row) {
        if (text(row, 1) == "ros2msg") types_.define(text(row, 0), text(row, 2));
      });
  }

  const std::vector<Topic>& topics() const { return topics_; }
  const MessageType* type_of(const Topic& topic) { return types_.find(topic.type); }
  const MessageType& known_type_of(const Topic& topic) {
    const MessageType* type = type_of(topic);
    if (type == nullptr)
      throw codegen::Error(
          fmt::format("{}: {} has messages of type {}, whose definition is neither in the bag nor built in: record "
                      "with ROS 2 Iron or newer, which puts it there, or republish as a type of std_msgs",
                      path_, topic.name, topic.type));
    return *type;
  }

  /// Calls visit(received [ns], bytes) for each message, in the order in which they were received; until it says false.
  template <class Visit>
  void messages(const Topic& topic, const Visit& visit) {
    query(
        "SELECT timestamp, data FROM messages WHERE topic_id = ?1 ORDER BY timestamp, id",
        [&](sqlite3_stmt* row) {
          const auto* bytes = static_cast<const char*>(sqlite().column_blob(row, 1));
          return visit(
              sqlite().column_int64(row, 0),
              std::string_view(bytes == nullptr ? "" : bytes, static_cast<std::size_t>(sqlite().column_bytes(row, 1))));
        },
        topic.id);
  }

  std::int64_t count(const Topic& topic) {
    std::int64_t count = 0;
    query(
        "SELECT COUNT(*) FROM messages WHERE topic_id = ?1",
        [&](sqlite3_stmt* row) { count = sqlite().column_int64(row, 0); }, topic.id);
    return count;
  }

  const std::string& path() const { return path_; }

 private:
  struct Close {
    void operator()(sqlite3* database) const { sqlite().close(database); }
    void operator()(sqlite3_stmt* statement) const { sqlite().finalize(statement); }
  };

  [[noreturn]] void fail() const {
    throw codegen::Error(
        fmt::format("{}: {}: the bag is damaged or was not copied whole; sqlite3 {} .recover saves what there is",
                    path_, sqlite().errmsg(database_.get()), path_));
  }

  bool has_table(const std::string& name) {
    bool found = false;
    query(fmt::format("SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = '{}'", name),
          [&](sqlite3_stmt*) { found = true; });
    return found;
  }

  static std::string text(sqlite3_stmt* row, int column) {
    const auto* bytes = static_cast<const char*>(sqlite().column_blob(row, column));
    return bytes == nullptr ? "" : std::string(bytes, static_cast<std::size_t>(sqlite().column_bytes(row, column)));
  }

  template <class Visit>
  void query(const std::string& sql, const Visit& visit, std::optional<std::int64_t> value = std::nullopt) {
    sqlite3_stmt* prepared = nullptr;
    if (sqlite().prepare_v2(database_.get(), sql.c_str(), -1, &prepared, nullptr) != SQLITE_OK) fail();
    const std::unique_ptr<sqlite3_stmt, Close> statement(prepared);
    if (value) sqlite().bind_int64(prepared, 1, *value);
    while (true) {
      const int status = sqlite().step(prepared);
      if (status == SQLITE_DONE) return;
      if (status != SQLITE_ROW) fail();
      if constexpr (std::is_same_v<decltype(visit(prepared)), bool>) {
        if (!visit(prepared)) return;
      } else {
        visit(prepared);
      }
    }
  }

  std::string path_;
  std::unique_ptr<sqlite3, Close> database_;
  std::vector<Topic> topics_;
  MessageTypes types_;
};

}  // namespace nlo::trainer
