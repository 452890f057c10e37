"""What the page knows: the newest messages of the run, and the last minutes of it as series."""
