"""What stands beside the scene: numbers, tables, plots and controls."""
