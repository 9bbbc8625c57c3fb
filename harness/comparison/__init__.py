"""The schemes beside each other: the command `esfem schemes`."""
