"""Elements, normals and area."""

from harness.mutation.registry.making import ASSEMBLY, one

JACOBIAN, GEOMETRY = "solver.geometry:from_jacobian", "solver.geometry:geometry"
FLAT = """element = reference_element(mesh.degree, quadrature_degree)
    corners = np.column_stack([1.0 - element.nodes.sum(axis=1), element.nodes])
    flat = np.empty_like(x)
    flat[mesh.cells] = corners @ x[mesh.cells[:, :3]]
    x = flat"""
RULE_OF = "element = reference_element(mesh.degree, quadrature_degree)"
FRAME, DUAL = "solver.geometry:frame", "cross(J1, N), cross(N, J0)"
GEOMETRY_MUTANTS = (
    one(
        "geometry",
        "no-inverse-metric",
        "grad u = J du",
        FRAME,
        DUAL,
        "times(det, J0), times(det, J1)",
    ),
    one(
        "geometry",
        "metric-off-diagonal",
        "stiffness with (J^T J)^-1_01 of the other sign",
        f"{ASSEMBLY}:local_stiffness",
        "in inverse_metric(geo)",
        "in np.array([[[1.0]], [[-1.0]], [[1.0]]]) * inverse_metric(geo)",
    ),
    one(
        "geometry",
        "dual-basis-swapped",
        "the columns of B exchanged",
        FRAME,
        DUAL,
        "cross(N, J0), cross(J1, N)",
    ),
    one(
        "geometry",
        "area-element-squared",
        "dA = det J^T J, in the solver and in the norms",
        JACOBIAN,
        "root * element.weights",
        "root**2 * element.weights",
    ),
    one(
        "geometry",
        "area-element-of-the-plane",
        "dA of the reference triangle",
        JACOBIAN,
        "root * element.weights",
        "np.ones_like(root) * element.weights",
    ),
    one(
        "geometry",
        "area-element-doubled",
        "dA twice as large",
        GEOMETRY,
        "J = np.swapaxes(reference_gradient(mesh, element, x), -1, -2)\n"
        "    return from_jacobian(mesh, element, values(mesh, element, x), J)",
        "J = np.swapaxes(reference_gradient(mesh, element, x), -1, -2)\n"
        "    geo = from_jacobian(mesh, element, values(mesh, element, x), J)\n"
        "    return Geometry(mesh, element, geo.points, 2.0 * geo.dA, geo.normal, geo.B)",
    ),
    one(
        "geometry",
        "normal-reversed",
        "inward normal of the mesh",
        FRAME,
        "1.0 / root",
        "-1.0 / root",
    ),
    one("geometry", "linear-geometry", "flat triangles at degree k", GEOMETRY, RULE_OF, FLAT),
    one(
        "geometry",
        "flat-nodes",
        "nodes of degree k on the chords",
        "solver.mesh:elevate",
        "raised, project(nodes)",
        "raised, nodes",
    ),
    one(
        "geometry",
        "edge-nodes-not-reversed",
        "edge nodes numbered as each element sees them",
        "solver.mesh:triangulation",
        "np.where(reversed_, along[::-1], along)",
        "np.where(reversed_, along, along)",
    ),
)
