"""How far a State is from an exact surface, an axisymmetric flow, or a finer mesh."""
