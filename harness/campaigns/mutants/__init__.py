"""Seeded bugs: is a wrong program seen to be wrong by the verdicts, and by which study?"""
