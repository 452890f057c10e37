"""What can be taken along: replay, CSV, pictures."""
