// Stand-in: what controller_interface::ControllerInterfaceBase of ros2_control declares, as far as it is overridden.
#pragma once
#include <cstdint>
#include <vector>

#include <rclcpp/rclcpp.hpp>

namespace hardware_interface {
struct LoanedStateInterface {
    double get_value() const { return 0.0; }
};
struct LoanedCommandInterface {
    [[nodiscard]] bool set_value(double) { return true; }
};
}  // namespace hardware_interface

namespace controller_interface {
enum class CallbackReturn : std::uint8_t { SUCCESS, FAILURE, ERROR };
enum class return_type : std::uint8_t { OK = 0, ERROR = 1 };
enum class interface_configuration_type : std::uint8_t { ALL = 0, INDIVIDUAL = 1, NONE = 2 };
struct InterfaceConfiguration {
    interface_configuration_type type;
    std::vector<std::string> names = {};
};
class ControllerInterface {
  public:
    virtual ~ControllerInterface() = default;
    virtual InterfaceConfiguration command_interface_configuration() const = 0;
    virtual InterfaceConfiguration state_interface_configuration() const = 0;
    virtual CallbackReturn on_init() = 0;
    virtual return_type update(const rclcpp::Time& time, const rclcpp::Duration& period) = 0;
    virtual CallbackReturn on_configure(const rclcpp_lifecycle::State&) { return CallbackReturn::SUCCESS; }
    virtual CallbackReturn on_activate(const rclcpp_lifecycle::State&) { return CallbackReturn::SUCCESS; }
    virtual CallbackReturn on_deactivate(const rclcpp_lifecycle::State&) { return CallbackReturn::SUCCESS; }
    std::shared_ptr<rclcpp_lifecycle::LifecycleNode> get_node() { return nullptr; }
    unsigned int get_update_rate() const { return 100; }
    template <class T> auto auto_declare(const std::string&, const T& value) { return value; }

  protected:
    std::vector<hardware_interface::LoanedCommandInterface> command_interfaces_;
    std::vector<hardware_interface::LoanedStateInterface> state_interfaces_;
};
}  // namespace controller_interface
