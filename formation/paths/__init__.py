"""Reference paths of the formation's centre."""
