"""What every room may use and knows no mathematics: bad input, files, TOML, tables, plots."""
