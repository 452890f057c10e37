"""What moves the formation by hand: the wheel of one page, clicks on the ground, and paths that are drawn."""
