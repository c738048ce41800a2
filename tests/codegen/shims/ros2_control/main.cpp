// SPDX-License-Identifier: MIT
// The manager: configures an exported controller, first wrongly, and updates it over the golden readings; compares it
// with an observer of the header bit for bit; then checks its messages on /diagnostics. CONTROLLER and REPLAY are the
// files to include, NLO_NAME the name of the model.
#include <type_traits>

#include CONTROLLER
#include REPLAY

namespace {

#define EXPECT(condition) \
  if (!(condition)) return std::printf("FAILED  line %d: %s\n", __LINE__, #condition), 1
#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)

namespace model = nlo::NLO_NAME;
namespace golden = nlo::NLO_NAME::replay;
using controller_interface::CallbackReturn;
using diagnostic_msgs::msg::DiagnosticStatus;

constexpr int kMeasured = sizeof(golden::kSamples[0].y) / sizeof(golden::kSamples[0].y[0]);
constexpr int kStates = sizeof(golden::kSamples[0].x_hat) / sizeof(golden::kSamples[0].x_hat[0]);
#ifdef NLO_DRIVEN
constexpr int kInputs = sizeof(golden::kSamples[0].u) / sizeof(golden::kSamples[0].u[0]);
#else
constexpr int kInputs = 0;
#endif

bool same(double got, double want) {
  return got == want || (got != got && want != want);
}

int run() {
  Exported controller;
  EXPECT(controller.on_init() == CallbackReturn::SUCCESS);
  auto& parameters = controller.get_node()->parameters;
  EXPECT(controller.on_configure({}) == CallbackReturn::FAILURE);  // no interfaces to read
  parameters["measured"].value = std::vector<std::string>(kMeasured, "sensor/one");
  parameters["inputs"].value = std::vector<std::string>(kInputs + 1, "sensor/other");
  EXPECT(controller.on_configure({}) == CallbackReturn::FAILURE);
  parameters["inputs"].value = std::vector<std::string>(kInputs, "sensor/other");
  EXPECT(controller.on_configure({}) == CallbackReturn::SUCCESS);
  EXPECT(controller.state_interface_configuration().names.size() == kMeasured + kInputs);
  EXPECT(controller.command_interface_configuration().type == controller_interface::interface_configuration_type::NONE);
  const auto exported = controller.export_state_interfaces();
  EXPECT(exported.size() >= kStates + 2 && exported[0].name.starts_with("estimator/"));
  controller.state_interfaces_.resize(kMeasured + kInputs);

  model::Observer observer{model::kModel};
#ifdef NLO_MONITOR
  model::Monitor monitor{model::kMonitor};
#endif
  for (int flight = 0; flight < 2; ++flight) {  // an activation resets the observer
    EXPECT(controller.on_activate({}) == CallbackReturn::SUCCESS);
    observer.reset();
#ifdef NLO_MONITOR
    monitor.reset();
#endif
    for (const golden::Sample& sample : golden::kSamples) {
      model::Observer::Output y{};
      for (int j = 0; j < kMeasured; ++j) {
        y[j] = sample.y[j];
        auto& read = controller.state_interfaces_[static_cast<std::size_t>(j)];
        read.value = y[j] == y[j] ? std::optional<double>(y[j]) : std::nullopt;
      }
#ifdef NLO_MONITOR
      y = monitor.usable_outputs(y, observer, sample.dt_s);
#endif
#ifdef NLO_DRIVEN
      model::Observer::Input u{};
      for (int j = 0; j < kInputs; ++j)
        controller.state_interfaces_[static_cast<std::size_t>(kMeasured + j)].value = u[j] = sample.u[j];
#define AND_U , u
#else
#define AND_U
#endif
      const bool regular = !(sample.dt_s > 0);
      const auto status = regular ? observer.step(y AND_U) : observer.step(y AND_U, sample.dt_s);
      const double dt = regular ? static_cast<double>(model::kModel.sample_period_s) : static_cast<double>(sample.dt_s);
      EXPECT(controller.update({}, {dt}) == controller_interface::return_type::OK);
      const auto x_hat = observer.estimate();
      for (int i = 0; i < kStates; ++i)
        EXPECT(same(*exported[static_cast<std::size_t>(i)].value, static_cast<double>(x_hat[i])));
      for (const auto& interface : exported) {
        if (interface.name.ends_with("/status")) EXPECT(same(*interface.value, static_cast<double>(status)));
        if (interface.name.ends_with("/in_domain")) EXPECT(same(*interface.value, observer.in_domain() ? 1.0 : 0.0));
      }
#ifdef NLO_MONITOR
      const auto alarm = monitor.watch(observer, x_hat);
      EXPECT(exported.back().name.ends_with("/alarm") && same(*exported.back().value, static_cast<double>(alarm)));
#endif
    }
  }

  using Message = diagnostic_msgs::msg::DiagnosticArray;
  auto node = controller.get_node();
  EXPECT(node->timer && node->timer->period_s == 1.0);
  node->timer->call();
  node->timer->call();  // no step since: no message
  const auto& sent = std::static_pointer_cast<rclcpp::Publisher<Message>>(node->publisher)->sent;
  EXPECT(sent.size() == 1 && sent[0].status.size() == 1);
  EXPECT(sent[0].status[0].level != DiagnosticStatus::OK);  // the golden readings contain missing ones
  EXPECT(sent[0].status[0].values[0].value == std::to_string(2 * std::size(golden::kSamples)));
  controller.on_activate({});
  const golden::Sample& good = golden::kSamples[0];
  for (int j = 0; j < kMeasured; ++j) controller.state_interfaces_[static_cast<std::size_t>(j)].value = good.y[j];
  controller.update({}, {0.0});
  node->timer->call();
  EXPECT(sent.size() == 2);
  parameters["diagnostics_period_s"].value = 0.0;
  EXPECT(controller.on_configure({}) == CallbackReturn::SUCCESS);
  return 0;
}

}  // namespace

int main() {
  return run();
}
