"""Quadrature, matrices and loads."""

from harness.mutation.registry.making import ELEMENT, one

LOADS = "solver.forms:local_loads"
RULE = "2 * degree + 2 if quadrature_degree is None"

ASSEMBLY_MUTANTS = (
    one(
        "assembly",
        "quadrature-degree-1",
        "one quadrature point",
        ELEMENT,
        RULE,
        "1 if quadrature_degree is None",
    ),
    one(
        "assembly",
        "quadrature-degree-k",
        "quadrature exact to degree k",
        ELEMENT,
        RULE,
        "degree if quadrature_degree is None",
    ),
    one(
        "assembly",
        "quadrature-degree-2k-1",
        "quadrature exact to degree 2k - 1",
        ELEMENT,
        RULE,
        "2 * degree - 1 if quadrature_degree is None",
        "exact for products of gradients, degree 2k - 2, on flat triangles, so A stays coercive; "
        "Bramble-Hilbert: the other errors are O(h^(k+1)) for smooth data",
    ),
    one(
        "assembly",
        "stiffness-half-mixed",
        "the mixed derivatives once instead of twice",
        "solver.reference_element:ReferenceElement.stiffness_table",
        "products[0, 1] + products[1, 0]",
        "products[0, 1]",
    ),
    one(
        "assembly",
        "gradient-load-sign",
        "int G . grad phi with the other sign",
        LOADS,
        "local[:3] += ",
        "local[:3] -= ",
    ),
    one(
        "assembly",
        "load-without-area",
        "loads without the area element",
        LOADS,
        "(geo.dA, geo.B",
        "(np.broadcast_to(geo.element.weights, geo.dA.shape), geo.B",
    ),
)
