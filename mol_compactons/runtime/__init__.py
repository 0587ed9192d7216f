"""What the program needs of the machine: the compilation of its kernels."""
