"""One robot's agent: its estimate of the upstream neighbour, its controller, and its process.

Run one with `python -m agents --id 1 --run NAME --connect ENDPOINT`.
"""
