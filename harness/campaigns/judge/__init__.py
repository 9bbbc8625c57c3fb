"""The judge, judged on tables of known order."""
