"""What the page knows: what was heard of the run, and the last minute of it as series."""
