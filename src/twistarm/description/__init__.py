"""Robot descriptions: URDF and xacro, read without ROS into a tree of links and joints."""
