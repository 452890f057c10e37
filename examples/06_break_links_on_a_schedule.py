"""Cut a link for three seconds, and see how old the plan behind it becomes."""

import echelon

simulation = echelon.Simulation(echelon.load("triangle-circle", {"duration": 10}))
simulation.step(300)
simulation.set_fault("1->2", cut=True, until=6.0)
while not simulation.finished:
    simulation.step(100)
    print(f"t = {simulation.time:4.1f} s: the plan is {simulation.observation(2).upstream.age:.2f} s old")
