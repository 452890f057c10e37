"""Simulate a scenario with late plans, print its largest error, draw it."""

import echelon

result = echelon.simulate("triangle-circle", {"link": {"latency": 0.3}, "duration": 20}, seed=3)
print(f"largest distance error in the last second: {1e3 * abs(result.distance_errors[-100:]).max():.3f} mm")
result.plot("triangle.png")
