"""What is run to be committed: the paper, the schemes beside each other, seeded bugs, baselines."""
