"""A ghost: the same episode under another controller, with the same faults, tick by tick beside the live one.

Run it with `python -m runtime.ghost --run NAME --connect ENDPOINT`. It idles until a comparison
is requested (`echelon control compare NAME`).
"""
