"""Scenario files: the tables, how they are read, and which controllers can be named in them."""
