"""A record on the page: read row by row onto a tape, and served without a run."""
