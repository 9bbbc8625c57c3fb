"""How the entries of the registry are made, and where in the program they act."""

from collections.abc import Sequence

from harness.mutation.patching import Edit, Mutant

ASSEMBLY = "solver.assembly"
STEP, EVOLVE = "solver.scheme:step", "solver.flow:evolve"
INITIAL, EXACT = "harness.start_states:initial_state", "harness.errors:exact_state"
ELEMENT = "solver.reference_element:reference_element"


def one(
    group: str, name: str, what: str, where: str, old: str, new: str, equivalent: str = ""
) -> Mutant:
    """A mutant of a single edit."""
    return Mutant(name, group, what, (Edit(where, old, new),), equivalent)


def term(
    group: str, name: str, formula: str, where: str, old: str, variants: Sequence[str]
) -> tuple[Mutant, ...]:
    """A term dropped, with the other sign, and twice as large."""
    ways = (("dropped", "dropped"), ("flipped", "with the other sign"), ("doubled", "doubled"))
    return tuple(
        one(group, f"{name}-{way}", f"{formula} {said}", where, old, new)
        for (way, said), new in zip(ways, variants, strict=True)
    )
