"""What every room may use and knows no mathematics: bad input, whole files, TOML, plots, origin."""
