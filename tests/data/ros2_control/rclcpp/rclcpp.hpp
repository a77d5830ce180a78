// Stand-in: as much of rclcpp and rclcpp_lifecycle as a small controller calls; signatures of their API documentation.
#pragma once
#include <cstddef>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>

namespace rclcpp {
struct Time {
    double seconds() const { return 0.0; }
};
struct Duration {
    double seconds() const { return 0.0; }
};
struct QoS {
    explicit QoS(std::size_t) {}
    QoS& best_effort() { return *this; }
};
template <class Message> struct Subscription {
    using SharedPtr = std::shared_ptr<Subscription>;
};
template <class Kind> struct Service {
    using SharedPtr = std::shared_ptr<Service>;
};
struct Logger {};
struct Clock {
    using SharedPtr = std::shared_ptr<Clock>;
};
struct Parameter {
    std::string as_string() const { return {}; }
    double as_double() const { return 0.0; }
    bool as_bool() const { return false; }
};
}  // namespace rclcpp

#define RCLCPP_ERROR(logger, ...) static_cast<void>(logger), std::printf(__VA_ARGS__)
#define RCLCPP_WARN(logger, ...) static_cast<void>(logger), std::printf(__VA_ARGS__)
#define RCLCPP_WARN_THROTTLE(logger, clock, ms, ...) \
    static_cast<void>(logger), static_cast<void>(clock), static_cast<void>(ms), std::printf(__VA_ARGS__)

namespace rclcpp_lifecycle {
struct State {};
struct LifecycleNode {
    template <class Message, class Callback>
    typename rclcpp::Subscription<Message>::SharedPtr create_subscription(const std::string&, const rclcpp::QoS&,
                                                                          Callback&& callback) {
        static_cast<void>(std::function<void(const Message&)>(callback));
        return nullptr;
    }
    template <class Kind, class Callback>
    typename rclcpp::Service<Kind>::SharedPtr create_service(const std::string&, Callback&& callback) {
        using Call = void(typename Kind::Request::SharedPtr, typename Kind::Response::SharedPtr);
        static_cast<void>(std::function<Call>(callback));
        return nullptr;
    }
    rclcpp::Parameter get_parameter(const std::string&) const { return {}; }
    rclcpp::Logger get_logger() const { return {}; }
    rclcpp::Clock::SharedPtr get_clock() { return nullptr; }
};
}  // namespace rclcpp_lifecycle
