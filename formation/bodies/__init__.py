"""What the robots are: the scenario's [bodies] table, and presets for it."""
