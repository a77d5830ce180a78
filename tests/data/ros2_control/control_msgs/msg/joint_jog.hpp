// Stand-in: fields as in control_msgs/msg/JointJog.msg.
#pragma once
#include <memory>
#include <string>
#include <vector>

namespace std_msgs::msg {
struct Header {
    std::string frame_id;
};
}  // namespace std_msgs::msg

namespace control_msgs::msg {
struct JointJog {
    std_msgs::msg::Header header;
    std::vector<std::string> joint_names;
    std::vector<double> displacements, velocities;
    double duration;
};
}  // namespace control_msgs::msg
