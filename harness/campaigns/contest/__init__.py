"""The schemes beside each other, in parts."""

STUDIES = "studies"
PARTS = (STUDIES, "cost", "comparison", "orders", "course")
