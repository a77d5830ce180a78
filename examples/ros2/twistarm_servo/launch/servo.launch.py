"""Start the servo, and a joystick's driver where `joy:=true`."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    config = PathJoinSubstitution([FindPackageShare("twistarm_servo"), "config", "servo.yaml"])
    simulated = {"use_sim_time": LaunchConfiguration("use_sim_time")}
    return LaunchDescription(
        [
            DeclareLaunchArgument("config", default_value=config, description="parameters of the servo"),
            DeclareLaunchArgument("use_sim_time", default_value="false", description="take the time from /clock"),
            DeclareLaunchArgument("joy", default_value="false", description="start a joystick's driver too"),
            Node(
                package="twistarm_servo",
                executable="servo_node",
                name="servo_node",
                output="screen",
                parameters=[LaunchConfiguration("config"), simulated],
            ),
            Node(
                package="joy",
                executable="joy_node",
                condition=IfCondition(LaunchConfiguration("joy")),
                parameters=[{"autorepeat_rate": 25.0}],
            ),
        ]
    )
