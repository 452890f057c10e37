"""Records of runs: MCAP files that hold ROS 2 messages, written by a recorder, read back, repaired, exported.

`python -m records` is the recorder's process. docs/records.md lists what a record holds.
"""
