"""From records to verdicts: the runs of a study judged, as tables, figures and files."""
