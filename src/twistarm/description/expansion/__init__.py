"""xacro to URDF without ROS: files confined, expressions examined before they are evaluated."""
