"""Families of runs with known answers: where `converge` says "converged", its error bar should hold the truth."""
