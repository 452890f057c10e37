"""Laws of what the dashboard shows, without a browser."""
