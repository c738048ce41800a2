// SPDX-License-Identifier: MIT
// The part of ros2_control (ROS 2 Jazzy) and rclcpp that an exported controller uses, without a manager or an executor.
#pragma once

#include <chrono>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace rclcpp_lifecycle {
struct State {};
}  // namespace rclcpp_lifecycle

namespace rclcpp {
struct Time {
  double value = 0.0;
};
struct Duration {
  double value = 0.0;
  double seconds() const { return value; }
};
struct Logger {};
struct TimerBase {
  using SharedPtr = std::shared_ptr<TimerBase>;
  std::function<void()> call;
  double period_s = 0.0;
};

template <class Message>
struct Publisher {
  std::vector<Message> sent;
  void publish(const Message& message) { sent.push_back(message); }
};

struct Parameter {
  std::variant<std::vector<std::string>, double> value;
  std::vector<std::string> as_string_array() const { return std::get<0>(value); }
  double as_double() const { return std::get<1>(value); }
};

struct Node {
  std::map<std::string, Parameter> parameters;
  std::shared_ptr<void> publisher;
  TimerBase::SharedPtr timer;

  const char* get_name() const { return "estimator"; }
  Logger get_logger() const { return {}; }
  Time now() const { return {1.0}; }
  Parameter get_parameter(const std::string& name) const { return parameters.at(name); }
  template <class Message>
  std::shared_ptr<Publisher<Message>> create_publisher(const std::string& topic, int depth) {
    if (topic != "/diagnostics" || depth < 1) throw topic;
    auto made = std::make_shared<Publisher<Message>>();
    publisher = made;
    return made;
  }
  template <class Call>
  TimerBase::SharedPtr create_wall_timer(std::chrono::duration<double> period, Call call) {
    return timer = std::make_shared<TimerBase>(TimerBase{call, period.count()});
  }
};
}  // namespace rclcpp

#define RCLCPP_ERROR(logger, ...) (void)(logger), std::printf(__VA_ARGS__), std::printf("\n")

namespace hardware_interface {
struct StateInterface {
  StateInterface(const std::string& prefix, const std::string& interface, double* at)
      : name(prefix + "/" + interface), value(at) {}
  std::string name;
  double* value;
};
struct LoanedStateInterface {
  std::optional<double> value;
  std::optional<double> get_optional() const { return value; }
};
}  // namespace hardware_interface

namespace controller_interface {
enum class CallbackReturn { SUCCESS, FAILURE, ERROR };
enum class return_type { OK, ERROR };
enum class interface_configuration_type { ALL, INDIVIDUAL, NONE };
struct InterfaceConfiguration {
  interface_configuration_type type;
  std::vector<std::string> names;
};

class ChainableControllerInterface {
 public:
  virtual ~ChainableControllerInterface() = default;
  virtual CallbackReturn on_init() = 0;
  virtual InterfaceConfiguration command_interface_configuration() const = 0;
  virtual InterfaceConfiguration state_interface_configuration() const = 0;
  virtual CallbackReturn on_configure(const rclcpp_lifecycle::State&) = 0;
  virtual CallbackReturn on_activate(const rclcpp_lifecycle::State&) = 0;
  std::shared_ptr<rclcpp::Node> get_node() const { return node_; }
  std::vector<hardware_interface::StateInterface> export_state_interfaces() { return on_export_state_interfaces(); }
  return_type update(const rclcpp::Time& time, const rclcpp::Duration& period) {
    if (update_reference_from_subscribers(time, period) != return_type::OK) return return_type::ERROR;
    return update_and_write_commands(time, period);
  }
  std::vector<hardware_interface::LoanedStateInterface> state_interfaces_;

 protected:
  template <class Value>
  void auto_declare(const std::string& name, const Value& value) {
    node_->parameters.emplace(name, rclcpp::Parameter{value});
  }
  virtual return_type update_reference_from_subscribers(const rclcpp::Time&, const rclcpp::Duration&) = 0;
  virtual return_type update_and_write_commands(const rclcpp::Time&, const rclcpp::Duration&) = 0;
  virtual std::vector<hardware_interface::StateInterface> on_export_state_interfaces() { return {}; }

 private:
  std::shared_ptr<rclcpp::Node> node_ = std::make_shared<rclcpp::Node>();
};
}  // namespace controller_interface
