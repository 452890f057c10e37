"""Robots of ROS 2 on routers of their own: rmw_zenoh's keys, tokens and bytes.

`python -m ros.body` drives a real robot; docs/ros.md is for users.
"""
