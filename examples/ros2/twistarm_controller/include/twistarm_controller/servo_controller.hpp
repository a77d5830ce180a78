// The ros2_control controller around servo_update.hpp: interfaces, parameters, topics and services.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include <control_msgs/msg/joint_jog.hpp>
#include <controller_interface/controller_interface.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <rclcpp/rclcpp.hpp>
#if __has_include(<realtime_tools/realtime_buffer.hpp>)
#include <realtime_tools/realtime_buffer.hpp>
#else
#include <realtime_tools/realtime_buffer.h>  // Humble
#endif
#include <std_srvs/srv/trigger.hpp>

#include "arm.hpp"  // of `twistarm bake`
#include "twistarm_controller/servo_update.hpp"

namespace twistarm_controller {
namespace robot = TWISTARM_ARM;  // the namespace in arm.hpp

/// A command and its number, 0 for none: `update` notes when the number changes, for the node's clock may be another one
/// than the controller manager's.
struct numbered_command {
    twistarm::servo_command<double, robot::n> command{};
    std::uint64_t number = 0;
};

constexpr double never = -1e18;  // [s]

class ServoController : public controller_interface::ControllerInterface {
  public:
    using Return = controller_interface::CallbackReturn;
    using State = rclcpp_lifecycle::State;

    Return on_init() override;
    controller_interface::InterfaceConfiguration command_interface_configuration() const override;
    controller_interface::InterfaceConfiguration state_interface_configuration() const override;
    Return on_configure(const State&) override;
    Return on_activate(const State&) override;
    Return on_deactivate(const State&) override;
    controller_interface::return_type update(const rclcpp::Time& time, const rclcpp::Duration& period) override;

  private:
    controller_interface::InterfaceConfiguration all_joints(const std::string& interface) const;
    void take(const geometry_msgs::msg::TwistStamped& message);
    void take(const control_msgs::msg::JointJog& message);
    void give(const twistarm::servo_command<double, robot::n>& command);
    void refuse(const std::string& why);
    void write();
    void serve(const std::string& name, bool enabled);
    bool by_velocity() const { return interface_ == "velocity"; }

    std::string interface_, base_, tip_;
    update_settings<double> settings_{};
    twistarm::servo_bounds<double, robot::n> bounds_ = robot::servo_bounds<double>;
    update_memory<double, robot::n> memory_{};
    double seen_ = never, heard_ = never;  // when every joint said a number, and when a command came
    std::uint64_t number_ = 0, given_ = 0;  // of the command heard last by update, and given last by a callback
    stopped_by told_ = stopped_by::nothing;
    std::atomic<bool> enabled_{false};
    realtime_tools::RealtimeBuffer<numbered_command> command_;
    rclcpp::Subscription<geometry_msgs::msg::TwistStamped>::SharedPtr twists_;
    rclcpp::Subscription<control_msgs::msg::JointJog>::SharedPtr jogs_;
    std::vector<rclcpp::Service<std_srvs::srv::Trigger>::SharedPtr> services_;
};
}  // namespace twistarm_controller
