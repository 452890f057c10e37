"""A ghost: the same flight under another controller, on the same faults, tick by tick beside the live one.

Run it with `python -m runtime.ghost --run NAME --connect ENDPOINT`. It idles until the world says that
somebody wants to compare (`echelon control compare NAME`).
"""
