// SPDX-License-Identifier: MIT
#pragma once

#include <any>
#include <map>
#include <typeindex>

namespace nlo::trainer {

/// Values found by their type, at most one of each. A module keeps its own values here beside those of all modules, so
/// that no other code knows its struct. A copy has copies of the values.
class ByType {
 public:
  /// The value of type T; T{} where none was set.
  template <class T>
  const T& get() const {
    static const T kDefault{};
    const auto found = values_.find(std::type_index(typeid(T)));
    return found == values_.end() ? kDefault : std::any_cast<const T&>(found->second);
  }

  /// Returns the value to write to; T{} at first.
  template <class T>
  T& set() {
    std::any& value = values_[std::type_index(typeid(T))];
    if (!value.has_value()) value.emplace<T>();
    return *std::any_cast<T>(&value);
  }

 private:
  std::map<std::type_index, std::any> values_;
};

}  // namespace nlo::trainer
