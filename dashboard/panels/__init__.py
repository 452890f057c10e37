"""The panels beside the scene: numbers, tables, plots and controls. A module's HTML is the template beside it."""
