"""Robots of ROS 2 on routers of their own, and a formation that ROS 2 sees: rmw_zenoh's keys, tokens and bytes.

`python -m ros.body` drives a real robot, `python -m ros.display` shows a run to ROS 2; docs/ros.md is for users.
"""
