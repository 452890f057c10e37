"""Ways that keep robots clear of each other: of lost ones on their return, and of all while the shape changes."""
