"""Code of a user's own: named by a command line or an API call, read once, imported in a namespace of its own."""
