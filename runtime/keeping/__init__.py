"""Keeps agents alive, as the world wishes: those of a host, or of one of several equal containers."""
