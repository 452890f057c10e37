"""The robots of a run as ROS 2 sees them."""
