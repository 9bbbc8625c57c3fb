"""Mesh widths: a column of them, from numbers of cells or unknowns, or from printed rates."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from esfem.cli.column_names import compact
from esfem.cli.column_reader import Asked, ColumnReader
from esfem.cli.printed_rates import contradicted, explained
from esfem.cli.series import GIVEN, Array
from esfem.common.bad_input import BadInput

DOUBLES = 3.0  # a number of cells that grows by more from level to level may be that of all cells


@dataclass(frozen=True)
class Widths:
    """Mesh widths, and where they are from; ``h`` is None in a table of time steps alone."""

    h: Array | None
    said: str
    name: str = "h"


def mesh_widths(reader: ColumnReader, asked: Asked, errors: Sequence[int], has_tau: bool) -> Widths:
    """The mesh widths: as asked; a column of them; from a number of cells; from printed rates."""
    given = {"--h": asked.h, "--dofs": asked.dofs, "--cells": asked.cells, "--ratio": asked.ratio}
    several = [option for option, value in given.items() if value is not None]
    if len(several) > 1:
        raise BadInput(f"{' and '.join(several)}: give one of them")
    if asked.h is not None:
        i = reader.find(asked.h, "--h")
        return Widths(reader.numbers(i), reader.shown(i), f"{GIVEN}{reader.shown(i)}")
    if asked.dofs is not None or asked.cells is not None:
        option = "--dofs" if asked.dofs is not None else "--cells"
        return _asked_count(reader, option, str(asked.dofs or asked.cells), asked.dim)
    if asked.ratio is not None:
        h = np.power(asked.ratio, np.arange(len(reader.table.rows), dtype=float))
        return Widths(h, f"{asked.ratio:g} times the one of the row above (--ratio)")
    if found := reader.of_kind("h"):
        i = _first_of(reader, found)
        return Widths(reader.numbers(i), reader.shown(i), reader.shown(i))
    return _counted(reader, asked.dim, errors, has_tau)


def _asked_count(reader: ColumnReader, option: str, name: str, dim: int | None) -> Widths:
    i = reader.find(name, option)
    if option == "--dofs" and dim is None:
        raise BadInput(f"--dofs {name}: needs --dim, for h = dofs^(-1 / dim)")
    return _of_count(reader, i, dim or 1)


def _of_count(reader: ColumnReader, i: int, dim: int, by: str = "") -> Widths:
    """h = N^(-1 / dim)."""
    values = reader.numbers(i)
    for j in np.flatnonzero(~(values > 0)).tolist():
        if np.isfinite(values[j]):
            place = reader.table.place(j)
            raise BadInput(f"{place}, column {reader.shown(i)}: {values[j]:g}: must be positive")
    name = reader.shown(i)
    base = f"({name})" if "/" in name else name
    power = f"1 / {base}" if dim == 1 else f"{base}^(-1/{dim})"
    return Widths(
        np.asarray(values ** (-1.0 / dim), dtype=np.float64), f"{power}{by}", f"{GIVEN}{name}"
    )


def _counted(reader: ColumnReader, dim: int | None, errors: Sequence[int], has_tau: bool) -> Widths:
    """Mesh widths of a table without a column of them."""
    cells = [i for i in reader.of_kind("cells") if _is_count(reader.loose(i))]
    dofs = [i for i in reader.of_kind("dofs") if _is_count(reader.loose(i))]
    if dim is not None:
        if not cells and not dofs:
            raise BadInput(f"--dim {dim}: there is no column of cells or dofs: give --dofs COLUMN")
        return _of_count(reader, (_of_all(reader, cells) or dofs or cells)[0], dim)
    if reader.table.halves:
        return _halved_by_trixi(reader, errors)
    if (meant := _by_printed_rates(reader, (*cells, *dofs), errors)) is not None:
        return meant
    if cells:
        return _per_direction(reader, cells)
    if has_tau:
        return Widths(None, "")
    if dofs:
        name = reader.shown(dofs[0])
        raise BadInput(f"there is no mesh width: give --dofs {name} --dim 1, 2 or 3")
    raise BadInput(
        f"no column of mesh widths is known among {reader.listed()}: give --h COLUMN, "
        "--cells COLUMN, --dofs COLUMN --dim D, --tau COLUMN, or --ratio R if each row refines "
        "the one above"
    )


def _of_all(reader: ColumnReader, cells: Sequence[int]) -> list[int]:
    """Columns that count all cells of a mesh, not those in a direction."""
    return [i for i in cells if compact(reader.shown(i)) not in ("n", "nx", "resolution")]


def _per_direction(reader: ColumnReader, cells: Sequence[int]) -> Widths:
    i = cells[0]
    values, name = reader.numbers(i), reader.shown(i)
    levels = np.unique(values[np.isfinite(values)])
    if len(levels) > 1 and (levels[1:] / levels[:-1]).min() >= DOUBLES:
        raise BadInput(
            f"column {name}: grows by {levels[1] / levels[0]:.3g} a level: is it the number of "
            f"cells in each direction (--cells {name}) or of all (--cells {name} --dim 2)?"
        )
    return _of_count(reader, i, 1)


def _is_count(values: Array) -> bool:
    """Whether numbers may be of cells: whole, growing, and not the numbers of the levels."""
    finite = values[np.isfinite(values)]
    if len(finite) < 2 or finite.min() < 1 or (finite != np.rint(finite)).any():
        return False
    return len(np.unique(finite)) > 1 and not (len(finite) > 2 and (np.diff(finite) == 1).all())


def _by_printed_rates(
    reader: ColumnReader, counts: Iterable[int], errors: Sequence[int]
) -> Widths | None:
    """Mesh widths that give the rates which the table prints beside its errors, None without such:
    those of a number of cells or dofs in 1, 2 or 3 dimensions, or halved from row to row."""
    rates = reader.of_kind("rate")
    halved = np.exp2(-np.arange(len(reader.table.rows), dtype=float))
    for i in counts:
        for dim in (1, 2, 3):
            h = np.asarray(reader.loose(i) ** (-1.0 / dim), float)
            if beside := explained(reader, rates, errors, h):
                by = f", as the rates beside {beside} say"
                return _of_count(reader, i, dim, by)
    if beside := explained(reader, rates, errors, halved):
        return Widths(halved, f"halved from row to row, as the rates beside {beside} say")
    return None


def _halved_by_trixi(reader: ColumnReader, errors: Sequence[int]) -> Widths:
    """Halved from row to row, as Trixi does, unless its own rates say another thing."""
    halved = np.exp2(-np.arange(len(reader.table.rows), dtype=float))
    if name := contradicted(reader, reader.of_kind("rate"), errors, halved):
        raise BadInput(
            f"the rates of {name} are not those of meshes that are halved from row to row: "
            "give --ratio R"
        )
    return Widths(halved, "halved from row to row, as Trixi does")


def _first_of(reader: ColumnReader, found: Sequence[int]) -> int:
    """h itself before other mesh widths; two of one name are unclear."""
    exact = [i for i in found if reader.shown(i) == "h"] or [
        i for i in found if compact(reader.shown(i)) in ("h", "hmax", "maxh")
    ]
    best = exact or list(found)
    if len(best) > 1:
        raise BadInput(f"{reader.those(best)}: choose the mesh width with --h COLUMN")
    return best[0]
