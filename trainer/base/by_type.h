// SPDX-License-Identifier: MIT
#pragma once

#include <any>
#include <map>
#include <typeindex>

namespace nlo::trainer {

/// Holds at most one value of each type. A module keeps its own values here, so that no other code needs to know its
/// struct. A copy has copies of the values.
class ByType {
 public:
  /// Returns the value of type T; T{} if none was set.
  template <class T>
  const T& get() const {
    static const T kDefault{};
    const auto found = values_.find(std::type_index(typeid(T)));
    return found == values_.end() ? kDefault : std::any_cast<const T&>(found->second);
  }

  /// Returns the value for writing; T{} at first.
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
