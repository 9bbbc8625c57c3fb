"""`esfem paper`: the experiments of the paper's section 7, and its quantitative sentences, checked.

The studies and flows are TOML files below harness/studies/paper; the sentences, each with the check
that decides about it, stand in `sentences.toml`.
"""
