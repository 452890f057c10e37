"""Compiled numerics; nothing here knows of messages or scenarios."""
