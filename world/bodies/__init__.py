"""The bodies of the robots: how they move and what localisation measures."""
