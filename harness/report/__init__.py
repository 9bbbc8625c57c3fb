"""The report of a folder of results, as one HTML file and as LaTeX, and two folders compared."""
