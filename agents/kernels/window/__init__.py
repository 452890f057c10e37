"""The window filter of one robot, compiled (docs/theory.md, section 12). estimation.py has the calls of Python."""
