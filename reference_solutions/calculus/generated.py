"""Partial derivatives of sympy expressions as NumPy functions, generated once a process.

The generated source is kept in memory alone: a file of it, read again and run, would run whatever
somebody had put there, and to generate it anew takes a quarter of a second for any surface here.
"""

from collections.abc import Callable, Sequence
from functools import cache
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
import sympy
from sympy.printing.numpy import NumPyPrinter

from esfem.reference_solutions.exact import Array

LARGEST_POWER = 32  # of those written as products

Index = tuple[int, ...]


def indices(variables: int, order: int) -> list[Index]:
    """The variables by which to differentiate, ascending: (), (0,), ..., (0, 0), (0, 1), ..."""
    return [
        index
        for total in range(order + 1)
        for index in combinations_with_replacement(range(variables), total)
    ]


@cache
def derivatives(
    expressions: tuple[sympy.Expr, ...], variables: tuple[sympy.Symbol, ...], order: int
) -> Callable[..., Array]:
    """All partial derivatives up to an order, exact to rounding.

    Returns
    -------
    function of as many arrays (n,) as there are variables, to (indices, expressions, n): entry
    [m, i] is the derivative of expression i by the variables `indices` (len(variables), order)[m].

    Raises
    ------
    ValueError
        If an expression has other symbols, or cannot be written in NumPy.
    """
    expressions = tuple(sympy.sympify(e, strict=True) for e in expressions)
    for expression in expressions:
        strange = expression.free_symbols - set(variables)
        if strange:
            names = ", ".join(sorted(map(str, strange)))
            allowed = ", ".join(map(str, variables))
            raise ValueError(f"{expression}: holds {names}, but its variables are {allowed}")
    namespace: dict[str, Any] = {"numpy": np, "power": power}
    exec(source(expressions, variables, order), namespace)
    return namespace["function"]


def source(expressions: Sequence[sympy.Expr], variables: Sequence[sympy.Symbol], order: int) -> str:
    """Python source of a function of the derivatives, with common subexpressions once."""
    table: dict[Index, list[sympy.Expr]] = {(): list(expressions)}
    for index in indices(len(variables), order)[1:]:
        table[index] = [sympy.diff(e, variables[index[-1]]) for e in table[index[:-1]]]
    flat = [entry for row in table.values() for entry in row]
    common, reduced = sympy.cse(flat, sympy.numbered_symbols("_t"), order="none")
    printer = Printer({"strict": True, "fully_qualified_modules": True})
    try:
        lines = [f"{symbol} = {printer.doprint(value)}" for symbol, value in common]
        lines += [
            f"_out[{m}, {i}] = {printer.doprint(reduced[m * len(expressions) + i])}"
            for m in range(len(table))
            for i in range(len(expressions))
            if reduced[m * len(expressions) + i] != 0
        ]
    except (NotImplementedError, TypeError) as error:
        reason = str(error).splitlines()[0]
        raise ValueError(f"{tuple(expressions)}: cannot be written in NumPy: {reason}") from error
    names = ", ".join(map(str, variables))
    shape = f"({len(table)}, {len(expressions)}, {variables[0]}.size)"
    body = "\n    ".join([f"_out = numpy.zeros({shape})", *lines, "return _out"])
    return f"def function({names}):\n    {body}\n"


class Printer(NumPyPrinter):  # type: ignore[misc]
    """Writes integer powers as products, for NumPy's are slow; a class, as sympy asks for one."""

    def _print_Pow(self, expr: sympy.Pow, **options: object) -> str:
        base, exponent = expr.as_base_exp()
        if exponent.is_Integer and 3 <= abs(int(exponent)) <= LARGEST_POWER:
            product = f"power({self._print(base)}, {abs(int(exponent))})"
            return product if exponent > 0 else f"(1.0/{product})"
        return super()._print_Pow(expr, **options)


def power(a: Array, n: int) -> Array:
    """a^n, n >= 1, by squaring."""
    if n == 1:
        return a
    half = power(a, n // 2)
    return half * half * a if n % 2 else half * half
