"""The web server, and who may open the page."""
