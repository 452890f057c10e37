"""How late may plans be? Two controllers, three latencies, a few seeds: mean and range, also of the paired ratio."""

import numpy as np

import echelon

NOISE = {"slip": 0.2, "gyro": 0.2, "position": 0.001, "heading": 0.01}
STUCK = [{"robot": 2, "at": 2, "until": 4, "drive": 0.0}]

if __name__ == "__main__":
    table = echelon.study(
        "triangle-circle",
        {"duration": 6, "noise": NOISE, "disturbances": STUCK, "robots": {"poses": None}},
        grid={"controller.name": ["nash", "virtual_structure"], "link.latency": [0.0, 0.1, 0.3]},
        seeds=3,
        measures=["distance_rms_m"],
    )
    error = table["distance_rms_m"].reshape(2, 3, 3) * 1e3  # controller, latency, seed [mm]
    for name, lines in zip(("nash", "virtual_structure"), error, strict=True):
        for latency, seeds in zip((0.0, 0.1, 0.3), lines, strict=True):
            print(f"{name:18} {latency:3.1f} s late: {seeds.mean():6.2f} mm ({seeds.min():.2f} to {seeds.max():.2f})")
    ratios = error[0] / error[1]
    print("nash against no messages, seed by seed:", np.round(ratios.mean(axis=1), 3))
