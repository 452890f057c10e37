"""Messages and transport: message types, key expressions, the faulty link, Zenoh sessions, the control protocol.

`python -m network` is the router process that world, agents and dashboard connect to.
"""
