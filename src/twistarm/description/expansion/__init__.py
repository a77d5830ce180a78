"""xacro to URDF without ROS, confined: files restricted, expressions checked, work counted."""
