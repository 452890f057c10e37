"""What every test may rely on: reproducible examples, and no time limit per example (a kernel may load on the first)."""

from hypothesis import settings

settings.register_profile("echelon", max_examples=60, deadline=None, derandomize=True, database=None)
settings.load_profile("echelon")
