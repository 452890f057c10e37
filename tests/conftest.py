"""What every test may rely on: reproducible examples, without a time limit (a kernel may load on the first)."""

from hypothesis import settings

settings.register_profile("echelon", max_examples=40, deadline=None, derandomize=True, database=None)
settings.load_profile("echelon")
