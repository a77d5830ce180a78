"""The package as colcon builds it."""

from glob import glob

from setuptools import setup

NAME = "twistarm_servo"

setup(
    name=NAME,
    version="0.1.0",
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", glob("launch/*.launch.py")),
        (f"share/{NAME}/config", glob("config/*.yaml")),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    maintainer="The maintainers of twistarm",
    maintainer_email="maintainer@example.org",
    description="Drives an arm by twists, joint rates, poses or a joystick through twistarm's servo",
    license="MIT",
    entry_points={"console_scripts": [f"servo_node = {NAME}.node:main"]},
)
