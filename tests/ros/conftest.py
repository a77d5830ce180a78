"""A real ROS 2: `make test-ros` sets its environment. Without it the tests of this folder skip.

Each run has a domain of its own on this computer alone, and ends what it started.
"""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "examples" / "ros2" / "twistarm_servo"


@pytest.fixture
def client(rover, monkeypatch):
    import rclpy

    from ros_client import Client

    monkeypatch.setenv("ROS_LOCALHOST_ONLY", "1")
    monkeypatch.setenv("ROS_DOMAIN_ID", str(os.getpid() % 100 + 1))
    rclpy.init()
    made = Client(rover)
    yield made
    made.node.destroy_node()
    rclpy.shutdown()


@pytest.fixture
def robot(client):
    from ros_client import Robot

    return Robot(client)


@pytest.fixture
def stick(client):
    from ros_client import Stick

    return Stick(client)


@pytest.fixture
def start(client):
    """Start a node with parameters and further arguments of ROS."""
    nodes: list[subprocess.Popen] = []

    def started(*arguments, **parameters):
        typed = [f"{name}:={value}" for name, value in ({"description": "rover_arm"} | parameters).items()]
        command = [sys.executable, "-m", "twistarm_servo.node", "--ros-args", *arguments]
        command += [word for pair in typed for word in ("-p", pair)]
        environment = os.environ | {"PYTHONPATH": str(PACKAGE)}
        node = subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True)
        nodes.append(node)
        return node

    yield started
    for node in nodes:
        if node.poll() is None:
            node.send_signal(signal.SIGINT)
            try:
                node.wait(10.0)
            except subprocess.TimeoutExpired:
                node.kill()
        node.communicate()
