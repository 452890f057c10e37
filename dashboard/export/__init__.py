"""Files that a user can export: replay, CSV, picture."""
