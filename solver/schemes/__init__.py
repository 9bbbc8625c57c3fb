"""The schemes beside which the paper sets its own (section 2.3), and that for mean curvature flow.

Each is one linearly implicit step; all matrices are those of the known surface.
"""
