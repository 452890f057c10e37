"""The public Python interface: what `import echelon` hands out."""
