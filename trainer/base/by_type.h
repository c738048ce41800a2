// SPDX-License-Identifier: MIT
#pragma once

#include <any>
#include <map>
#include <typeindex>

namespace nlo::trainer {

/// Values found by their type, at most one of each: the place for what a module keeps beside what all of them have, so
/// that its struct is known to nobody else. Copied with its values.
class ByType {
 public:
  /// The value of type T; T{} where none was set.
  template <class T>
  const T& get() const {
    static const T kDefault{};
    const auto found = values_.find(std::type_index(typeid(T)));
    return found == values_.end() ? kDefault : std::any_cast<const T&>(found->second);
  }

  /// The same to write to; T{} at first.
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
