"""Paths that are driven while the run goes on: how the centre answers to orders (docs/theory.md, section 18)."""
