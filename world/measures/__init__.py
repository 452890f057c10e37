"""What an episode is measured by: its trace, contacts, convergence of solvers."""
