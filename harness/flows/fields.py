"""The nodal fields that files and pictures of a flow show."""

from solver import State
from solver.reference_element import Array


def shown(state: State) -> dict[str, Array]:
    """nu, H, V, z and v by the paper's letters, (N,) or (N, 3)."""
    return {"nu": state.nu, "H": state.H, "V": state.V, "z": state.z, "v": state.v}
