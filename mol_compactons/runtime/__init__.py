"""What the program needs of the machine: compilation, floating-point modes."""
