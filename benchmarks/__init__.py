"""Speed, memory and accuracy, measured: never asserted with a clock in a test."""
