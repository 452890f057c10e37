"""The dashboard: a web page with the scene, run control, faults, plots and the event log of a run.

Run it with `python -m dashboard --run NAME --connect ENDPOINT`. It owns no state of the run: it shows what
the world and the agents publish, and everything that a user does is a request to the world.
"""
