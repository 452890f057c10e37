"""Who may open the page, and the server behind it."""
