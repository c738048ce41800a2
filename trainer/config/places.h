// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace nlo::trainer {

/// Stores the place of each key ("observer.hold") and section ("log", "log.columns[2]"): "FILE:LINE" or "--set
/// KEY=VALUE".
class Places {
 public:
  explicit Places(std::string filename) : filename_(std::move(filename)) {}

  void note(const std::string& path, std::string place) { places_[path] = std::move(place); }
  bool has(const std::string& path) const { return places_.contains(path); }

  /// Returns all paths, in order.
  std::vector<std::string> paths() const {
    std::vector<std::string> all;
    for (const auto& [path, place] : places_) all.push_back(path);
    return all;
  }

  /// Returns the place of the path; otherwise of its section; otherwise the file.
  std::string of(const std::string& path) const {
    for (std::string at = path; !at.empty();) {
      if (const auto found = places_.find(at); found != places_.end()) return found->second;
      const auto dot = at.rfind('.');
      at = dot == std::string::npos ? "" : at.substr(0, dot);
    }
    return filename_;
  }

 private:
  std::string filename_;
  std::map<std::string, std::string> places_;
};

}  // namespace nlo::trainer
