#include "twistarm_controller/servo_controller.hpp"

#include <cmath>

#include <pluginlib/class_list_macros.hpp>

namespace twistarm_controller {
using controller_interface::InterfaceConfiguration;
using controller_interface::return_type;

ServoController::Return ServoController::on_init() {
    auto_declare<std::string>("interface", "position");
    auto_declare<std::string>("base_frame", "base_link");
    auto_declare<std::string>("tip_frame", "tool0");
    auto_declare<bool>("enabled_at_start", true);
    auto_declare<std::string>("on_unreachable", "slide");
    auto_declare<double>("command_timeout", 0.2);
    auto_declare<double>("tolerance", 0.2);
    return Return::SUCCESS;
}

InterfaceConfiguration ServoController::all_joints(const std::string& interface) const {
    InterfaceConfiguration wanted{controller_interface::interface_configuration_type::INDIVIDUAL, {}};
    for (const char* name : robot::joint_names) wanted.names.push_back(std::string(name) + "/" + interface);
    return wanted;
}

InterfaceConfiguration ServoController::command_interface_configuration() const { return all_joints(interface_); }

InterfaceConfiguration ServoController::state_interface_configuration() const { return all_joints("position"); }

ServoController::Return ServoController::on_configure(const State&) {
    const auto node = get_node();
    interface_ = node->get_parameter("interface").as_string();
    base_ = node->get_parameter("base_frame").as_string();
    tip_ = node->get_parameter("tip_frame").as_string();
    settings_.command_timeout = node->get_parameter("command_timeout").as_double();
    settings_.tolerance = node->get_parameter("tolerance").as_double();
    if (interface_ != "position" && interface_ != "velocity") {
        RCLCPP_ERROR(node->get_logger(), "interface must be position or velocity; got %s", interface_.c_str());
        return Return::ERROR;
    }
    const std::string on_unreachable = node->get_parameter("on_unreachable").as_string();
    if (on_unreachable != "slide" && on_unreachable != "stop") {
        RCLCPP_ERROR(node->get_logger(), "on_unreachable must be slide or stop; got %s", on_unreachable.c_str());
        return Return::ERROR;
    }
    bounds_.stops = on_unreachable == "stop";
    if (!(settings_.command_timeout > 0.0) || !(settings_.tolerance > 0.0)) {
        RCLCPP_ERROR(node->get_logger(), "command_timeout and tolerance must be positive");
        return Return::ERROR;
    }
    for (int k = 0; k < robot::n; ++k)
        if (std::isinf(robot::acceleration[k]) || std::isinf(robot::velocity[k])) {
            RCLCPP_ERROR(node->get_logger(), "%s has no velocity or no acceleration limit: bake the arm with --limits",
                         robot::joint_names[k]);
            return Return::ERROR;
        }
    twists_ = node->create_subscription<geometry_msgs::msg::TwistStamped>(
        "~/delta_twist_cmds", rclcpp::QoS(1).best_effort(),
        [this](const geometry_msgs::msg::TwistStamped& message) { take(message); });
    jogs_ = node->create_subscription<control_msgs::msg::JointJog>(
        "~/delta_joint_cmds", rclcpp::QoS(1).best_effort(),
        [this](const control_msgs::msg::JointJog& message) { take(message); });
    services_.clear();
    serve("~/enable", true);
    serve("~/stop", false);
    return Return::SUCCESS;
}

void ServoController::serve(const std::string& name, bool enabled) {
    using Trigger = std_srvs::srv::Trigger;
    services_.push_back(get_node()->create_service<Trigger>(
        name, [this, enabled](const Trigger::Request::SharedPtr, Trigger::Response::SharedPtr response) {
            enabled_ = enabled;
            response->success = true;
            response->message = enabled ? "enabled" : "stopped";
        }));
}

ServoController::Return ServoController::on_activate(const State&) {
    memory_ = {};
    seen_ = heard_ = never;
    settings_.period = 1.0 / static_cast<double>(get_update_rate());
    command_.initRT(numbered_command{});
    number_ = 0;
    enabled_ = get_node()->get_parameter("enabled_at_start").as_bool();
    return Return::SUCCESS;
}

ServoController::Return ServoController::on_deactivate(const State&) {
    for (int k = 0; k < robot::n; ++k) memory_.state.theta_dot[k] = 0.0;
    if (memory_.started) write();
    return Return::SUCCESS;
}

return_type ServoController::update(const rclcpp::Time& time, const rclcpp::Duration& period) {
    const double now = time.seconds();
    const numbered_command& given = *command_.readFromRT();
    if (given.number == 0) heard_ = never;
    else if (given.number != number_) heard_ = now;
    number_ = given.number;
    update_input<double, robot::n> in{};
    bool numbers = true;
    for (int k = 0; k < robot::n; ++k) {
        in.theta[k] = state_interfaces_[static_cast<std::size_t>(k)].get_value();
        numbers = numbers && std::isfinite(in.theta[k]);
    }
    if (numbers) seen_ = now;
    in.state_age = now - seen_;
    in.command_age = now - heard_;
    in.dt = period.seconds();
    in.command = given.command;
    in.enabled = enabled_;
    update_output<double> out{};
    twistarm_controller::update(robot::chain<double>, bounds_, settings_, in, memory_, out);
    if (out.reason != told_ && out.reason != stopped_by::nothing)
        RCLCPP_WARN(get_node()->get_logger(), "%s", text(out.reason));
    told_ = out.reason;
    if (out.valid) write();
    return return_type::OK;
}

void ServoController::write() {
    for (int k = 0; k < robot::n; ++k) {
        const double value = by_velocity() ? memory_.state.theta_dot[k] : memory_.state.theta[k];
        static_cast<void>(command_interfaces_[static_cast<std::size_t>(k)].set_value(value));
    }
}

void ServoController::take(const geometry_msgs::msg::TwistStamped& message) {
    const std::string& frame = message.header.frame_id;
    if (frame != base_ && frame != tip_) return refuse("a twist is given in " + base_ + " or " + tip_ + "; got '" + frame + "'");
    twistarm::servo_command<double, robot::n> command{};
    command.kind = twistarm::servo_kind::twist;
    command.base_axes = frame == base_;
    const auto &v = message.twist.linear, &w = message.twist.angular;
    const double twist[6] = {v.x, v.y, v.z, w.x, w.y, w.z};
    for (int k = 0; k < 6; ++k) command.twist[k] = twist[k];
    give(command);
}

void ServoController::take(const control_msgs::msg::JointJog& message) {
    if (message.joint_names.size() != message.velocities.size() || !message.displacements.empty())
        return refuse("a jog has as many velocities as joint_names, and no displacements");
    twistarm::servo_command<double, robot::n> command{};
    command.kind = twistarm::servo_kind::jog;
    bool named[robot::n] = {};
    for (std::size_t i = 0; i < message.joint_names.size(); ++i) {
        int k = 0;
        while (k < robot::n && message.joint_names[i] != robot::joint_names[k]) ++k;
        if (k == robot::n || named[k]) return refuse("no joint, or named twice: " + message.joint_names[i]);
        named[k] = true;
        command.rates[k] = message.velocities[i];
    }
    give(command);
}

void ServoController::give(const twistarm::servo_command<double, robot::n>& command) {
    command_.writeFromNonRT(numbered_command{command, ++given_});
}

/// What makes no sense stops the arm, as silence does.
void ServoController::refuse(const std::string& why) {
    command_.writeFromNonRT(numbered_command{});
    RCLCPP_WARN_THROTTLE(get_node()->get_logger(), *get_node()->get_clock(), 2000, "refused: %s", why.c_str());
}
}  // namespace twistarm_controller

PLUGINLIB_EXPORT_CLASS(twistarm_controller::ServoController, controller_interface::ControllerInterface)
