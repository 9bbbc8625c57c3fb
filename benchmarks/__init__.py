"""How long a step takes, and how much less than the textbook way: `make bench`."""
