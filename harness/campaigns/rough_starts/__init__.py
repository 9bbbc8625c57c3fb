"""The order in time of flows whose first moments are fast, measured: docs/rough-starts.md."""
