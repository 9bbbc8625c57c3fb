r"""Synthetic tables with known truth.  What is right was settled before the first run.

Truth is the order as the swept parameter goes to 0 with the other term of the error taken away:
of A h^p + B tau^q swept in h it is p, of 10 h^3 + 0.03 h it is 1, of errors that grow or never
settle it is negative or 0.  With d = 0.2 and claim k:

* a *false pass* is PASS or SUPER where truth < k - d, or where the terms cancel (truth NaN);
* a *false fail* is FAIL or SUSPECT where truth >= k - d, but SUSPECT is right above k + 1.5;
* INCONCLUSIVE is never false, and it is not right either: its share is shown.

Where two terms make an error, the one that rules as h -> 0 is at least as large as the other on the
finest level: if it were smaller, the table would not show the order that counts as its truth.  The
kinds marked ``limit`` leave that ground or ask for more than a table shows: *hidden*, where the low
power holds only 10 to 50 % on the finest level; *close*, h^(k+1/2) + h^(k-1/2) claimed to be k,
whose slope over four levels is k to 0.2; a truth 0.3 below the claim, 0.1 from what is accepted,
behind a second term; the singular part of an L-shaped domain behind scatter.  They are shown apart
and not in the totals.

*Clean* tables, which should PASS: a pure power of the claimed order, scatter of 2 % at most.

Totals are means over kinds.  ``held_out`` kinds are drawn for the report alone; nobody tunes on
them.
"""

from esfem.campaigns.judge.grown_kinds import grown_kinds
from esfem.campaigns.judge.instance import Kind
from esfem.campaigns.judge.todays_kinds import todays_kinds


def kinds() -> tuple[Kind, ...]:
    """All kinds of tables."""
    return (*todays_kinds(), *grown_kinds())
