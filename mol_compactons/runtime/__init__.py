"""What the program needs of the machine: compiled kernels, room that threads do not share, and what C libraries say."""
