"""The ground truth: bodies, noise, stepping, the watchdog, the faults in force, and the process that owns them.

Run it with `python -m world --scenario NAME --run NAME --connect ENDPOINT`.
"""
