"""xacro to URDF text, without ROS and in a cage: files confined, expressions checked, work counted."""
