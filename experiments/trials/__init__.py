"""Trials: a scenario with overrides and a seed, simulated and measured; many of them on all cores or a cluster."""
