"""A ROS 2 node around twistarm's servo; see README.md of the package."""
