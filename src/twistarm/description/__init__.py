"""Robot descriptions: reading URDF and xacro without ROS into a tree of links and joints, with findings."""
