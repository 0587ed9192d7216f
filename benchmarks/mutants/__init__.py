"""Single faults put into a copy of the package, to learn whether the tests notice them."""
