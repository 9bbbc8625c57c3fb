"""The columns of records.csv that have the errors of variables, from norms at each time."""

from collections.abc import Iterable, Mapping, Sequence

from esfem.measuring.lift import in_h1

# Of u_h - u, of u_h - I_h u, and of the initial State kept for ever in place of u_h.
COLUMNS = ("err_{}", "err_{}_l2", "t_{}", "nodal_{}", "nodal_{}_l2", "t_nodal_{}", "idle_{}")
Series = Mapping[str, Sequence[float]]  # by variable


def columns(variables: Iterable[str]) -> list[str]:
    """All columns of these variables."""
    return [column.format(name) for name in variables for column in COLUMNS]


def largest(
    kind: str, when: str, t: Sequence[float], l2: Series, seminorm: Series, length: float
) -> dict[str, float]:
    """``<kind>_<variable>``, the largest norm in H^1, ``<when>_<variable>``, the time of t at which
    it is attained, and ``<kind>_<variable>_l2``, the largest in L^2.

    Parameters
    ----------
    kind, when : how the names of the columns begin.
    t : times.
    l2, seminorm : by variable, a number a time.
    length : the unit of length.
    """
    found = {}
    for name, errors in in_h1(l2, seminorm, length).items():
        worst = max(range(len(t)), key=errors.__getitem__)
        found[f"{kind}_{name}"] = errors[worst]
        found[f"{kind}_{name}_l2"] = max(l2[name])
        found[f"{when}_{name}"] = t[worst]
    return found


def largest_idle(l2: Series, seminorm: Series, length: float) -> dict[str, float]:
    """``idle_<variable>``, the largest norm in H^1."""
    return {f"idle_{name}": max(errors) for name, errors in in_h1(l2, seminorm, length).items()}
