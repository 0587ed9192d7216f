"""Linear algebra of the integrators: Newton's matrix and its factors."""
