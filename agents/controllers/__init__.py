"""The controllers: their interface, their registry, and a module for each."""
