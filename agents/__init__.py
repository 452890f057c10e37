"""One robot's mind: what it believes of its upstream neighbour, how it plans, and its process.

Run one with `python -m agents --id 1 --run NAME --connect ENDPOINT`.
"""
