"""The controllers: what they are given, what they return, and each of them."""
