// SPDX-License-Identifier: MIT
// Bags of ROS 2 (rosbag2) in SQLite. A column is a topic and a number in its messages ("/imu/linear_acceleration.x"),
// the time a topic's stamps ("/imu/header.stamp") or when its messages were received ("/imu"). Rows are that topic's
// messages.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>

#include "codegen/base/error.h"
#include "trainer/base/nearest_name.h"
#include "trainer/base/printable.h"
#include "trainer/recordings/cdr_message.h"
#include "trainer/recordings/recording.h"

#ifdef NLO_SQLITE
#include "trainer/recordings/bag.h"
#endif

namespace nlo::trainer {

#ifndef NLO_SQLITE
Recording read_rosbag(const std::string& path, const WantedColumns&) {
  throw codegen::Error(fmt::format(
      "{}: this nlo was built without SQLite, which reads bags: install libsqlite3-dev and build again", path));
}
#else
namespace {

using codegen::Error;
using Eigen::Index;
using Eigen::VectorXd;

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

/// A heading, apart: the longest topic that it begins with, and the way into its messages.
struct Place {
  const Topic* topic = nullptr;
  std::string path;  ///< empty: none
};

Place place_of(const Bag& bag, const std::string& heading) {
  Place found;
  std::vector<std::string> names;
  for (const Topic& topic : bag.topics()) {
    names.push_back(topic.name);
    const bool whole = heading == topic.name;
    if (!whole && !heading.starts_with(topic.name + "/")) continue;
    if (found.topic != nullptr && found.topic->name.size() >= topic.name.size()) continue;
    found = {&topic, whole ? "" : heading.substr(topic.name.size() + 1)};
  }
  if (found.topic == nullptr) {
    const std::string nearest = nearest_name(heading.substr(0, heading.rfind('/')), names);
    throw Error(fmt::format("{}: no topic of \"{}\" among {}{}", bag.path(), ascii(heading),
                            ascii(fmt::format("{}", fmt::join(names, ", "))),
                            nearest.empty() ? "" : fmt::format("; did you mean {}?", ascii(nearest))));
  }
  return found;
}

/// Messages of a topic as numbers, by their time.
struct Series {
  std::vector<std::int64_t> time_ns;
  std::vector<std::vector<double> > values;  ///< a list for each path
};

constexpr const char* kStamp = "header.stamp";

Series series_of(Bag& bag, const Topic& topic, const std::vector<std::string>& paths, const std::string& time_path) {
  const MessageType& type = bag.known_type_of(topic);
  std::vector<MessageValue> wanted;
  for (const std::string& path : paths) try {
      wanted.emplace_back(type, path);
    } catch (const Error& error) {
      throw Error(fmt::format("{}: {}/{}: {}", bag.path(), topic.name, path, error.what()));
    }
  if (!time_path.empty()) wanted.emplace_back(type, time_path);
  Series series;
  series.values.resize(paths.size());
  bag.messages(topic, [&](std::int64_t received_ns, std::string_view bytes) {
    try {
      read_message(type, bytes, wanted);
    } catch (const Error& error) {
      throw Error(fmt::format("{}: message {} of {} {}: the bag is damaged, or its messages are not of type {}",
                              bag.path(), series.time_ns.size() + 1, topic.name, error.what(), topic.type));
    }
    series.time_ns.push_back(time_path.empty() ? received_ns : wanted.back().nanoseconds);
    for (std::size_t j = 0; j < paths.size(); ++j) series.values[j].push_back(wanted[j].value);
    return true;
  });
  return series;
}

/// What was new since the row before; nothing where nothing was.
VectorXd held(const std::vector<std::int64_t>& rows_ns, const Series& series, const std::vector<std::size_t>& order,
              std::size_t column) {
  VectorXd values = VectorXd::Constant(static_cast<Index>(rows_ns.size()), kNothing);
  std::size_t next = 0;
  for (std::size_t k = 0; k < rows_ns.size(); ++k) {
    const std::size_t before = next;
    while (next < order.size() && series.time_ns[order[next]] <= rows_ns[k]) ++next;
    if (next > before) values[static_cast<Index>(k)] = series.values[column][order[next - 1]];
  }
  return values;
}

/// Lines between messages; nothing before the first, behind the last, and where several are missing.
VectorXd interpolated(const std::vector<std::int64_t>& rows_ns, const Series& series,
                      const std::vector<std::size_t>& order, std::size_t column, double wrap) {
  constexpr double kLongest = 5.0;  // of the median step
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < order.size(); ++i)
    steps.push_back(series.time_ns[order[i]] - series.time_ns[order[i - 1]]);
  double longest = 0.0;
  if (!steps.empty()) {
    std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
    longest = kLongest * static_cast<double>(steps[steps.size() / 2]);
  }
  VectorXd values = VectorXd::Constant(static_cast<Index>(rows_ns.size()), kNothing);
  std::size_t next = 0;
  for (std::size_t k = 0; k < rows_ns.size(); ++k) {
    while (next < order.size() && series.time_ns[order[next]] < rows_ns[k]) ++next;
    if (next == order.size()) break;
    const double after = series.values[column][order[next]];
    if (series.time_ns[order[next]] == rows_ns[k]) values[static_cast<Index>(k)] = after;
    if (series.time_ns[order[next]] == rows_ns[k] || next == 0) continue;
    const double before = series.values[column][order[next - 1]];
    const auto step = static_cast<double>(series.time_ns[order[next]] - series.time_ns[order[next - 1]]);
    if (step > longest) continue;
    const double share = static_cast<double>(rows_ns[k] - series.time_ns[order[next - 1]]) / step;
    const double way = wrap > 0.0 ? std::remainder(after - before, wrap) : after - before;
    values[static_cast<Index>(k)] = before + share * way;
  }
  return values;
}

/// All numbers of topics whose types are known, and the time of the topic that has most messages.
WantedColumns all_columns(Bag& bag) {
  WantedColumns all;
  std::int64_t most = 0;
  for (const Topic& topic : bag.topics()) {
    const MessageType* type = bag.type_of(topic);
    if (type == nullptr) continue;
    std::vector<std::string> paths;
    bag.messages(topic, [&](std::int64_t, std::string_view bytes) {
      try {
        paths = numbers_in(*type, bytes);
      } catch (const Error&) {  // a type within it is not known
      }
      return false;
    });
    for (const std::string& path : paths) all.columns.push_back({topic.name + "/" + path});
    const std::int64_t count = paths.empty() ? 0 : bag.count(topic);
    if (count <= most) continue;
    most = count;
    const MessageField* header = type->field("header");
    const bool stamped = header != nullptr && header->type == "std_msgs/Header";
    all.time = topic.name + (stamped ? fmt::format("/{}", kStamp) : "");
  }
  if (all.columns.empty())
    throw Error(
        fmt::format("{}: no topic has numbers of a known type: record with ROS 2 Iron or newer, which puts "
                    "definitions into the bag",
                    bag.path()));
  return all;
}

}  // namespace

Recording read_rosbag(const std::string& path, const WantedColumns& given) {
  Bag bag(path);
  const WantedColumns wanted = given.columns.empty() ? all_columns(bag) : given;
  const Place time = place_of(bag, wanted.time.empty() ? wanted.columns.front().heading : wanted.time);
  const std::string time_path = wanted.time.empty() ? "" : time.path;
  const Series base = series_of(bag, *time.topic, {}, time_path);
  if (base.time_ns.empty()) throw Error(fmt::format("{}: {} has no messages", path, time.topic->name));

  Recording recording;
  const Index offset = wanted.time.empty() ? 0 : 1, rows = static_cast<Index>(base.time_ns.size());
  recording.numbers.resize(rows, offset + static_cast<Index>(wanted.columns.size()));
  if (offset == 1) {
    recording.headings.push_back(wanted.time);
    for (Index k = 0; k < rows; ++k)  // from the first: seconds since 1970 have 0.2 us in a double
      recording.numbers(k, 0) = 1e-9 * static_cast<double>(base.time_ns[static_cast<std::size_t>(k)] - base.time_ns[0]);
  }
  std::vector<Place> places;
  for (const WantedColumn& column : wanted.columns) {
    places.push_back(place_of(bag, column.heading));
    recording.headings.push_back(column.heading);
    if (places.back().path.empty())
      throw Error(fmt::format("{}: {} is a topic: name a number of its messages, as {}/data", path, column.heading,
                              column.heading));
  }
  for (const Topic& topic : bag.topics()) {
    std::vector<std::string> paths;
    std::vector<std::size_t> columns;
    for (std::size_t j = 0; j < places.size(); ++j)
      if (places[j].topic == &topic) paths.push_back(places[j].path), columns.push_back(j);
    if (paths.empty()) continue;
    // Stamps are compared with stamps, where there are any: a message may be received late.
    const bool same = &topic == time.topic, stamped = time_path == kStamp;
    const MessageField* header = bag.known_type_of(topic).field("header");
    const bool has_stamp = header != nullptr && header->type == "std_msgs/Header";
    const Series series = series_of(bag, topic, paths, stamped && has_stamp ? kStamp : "");
    std::vector<std::size_t> order(series.time_ns.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return series.time_ns[i]; });
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const WantedColumn& column = wanted.columns[columns[i]];
      recording.numbers.col(offset + static_cast<Index>(columns[i])) =
          same                  ? VectorXd(Eigen::Map<const VectorXd>(series.values[i].data(), rows))
          : column.interpolated ? interpolated(base.time_ns, series, order, i, column.wrap)
                                : held(base.time_ns, series, order, i);
    }
  }
  return recording;
}
#endif

}  // namespace nlo::trainer
