// Stand-in: fields as in geometry_msgs/msg/TwistStamped.msg.
#pragma once
#include <control_msgs/msg/joint_jog.hpp>

namespace geometry_msgs::msg {
struct Vector3 {
    double x, y, z;
};
struct Twist {
    Vector3 linear, angular;
};
struct TwistStamped {
    std_msgs::msg::Header header;
    Twist twist;
};
}  // namespace geometry_msgs::msg
