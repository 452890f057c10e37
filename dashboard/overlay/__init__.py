"""What lies over the scene: status line, robots' numbers and chips, time line; placed by a script of each page."""
