"""What a person sees and touches: a web page with the scene, run control, faults, plots and the log of a live run.

Run it with `python -m dashboard --run NAME --connect ENDPOINT`. It owns no state: everything that it shows is what the
world and the agents say, everything that a person does is a request to the world.
"""
