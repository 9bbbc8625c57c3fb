"""The energies of flows: what is checked of them, and histories of versions that had W alone."""

from dataclasses import replace

import numpy as np
import pytest
from studies import write_flow

from esfem.flows.checks import checked, energy_decreases, energy_falls
from esfem.flows.flow_file import load_flow
from esfem.flows.flow_results import Ended
from esfem.flows.history import BEFORE, COLUMNS, History, read_history
from esfem.solver.laws import energy_of

W = energy_of("willmore")
HELFRICH = ('name = "willmore"', 'name = "helfrich"\nspontaneous_curvature = 1.0')
DIFFUSION = ('name = "willmore"', 'name = "surface_diffusion"')


def made(energies, law="willmore", **parameters):
    """A History with these energies, and with a W that always rises."""
    history = History(energy_of(law, **parameters))
    for t, E in enumerate(energies):
        row = {"t": float(t), "energy": E, "willmore": 1.0 + t}
        history.rows.append(tuple(row.get(name, 0.0) for name in COLUMNS))
    return history


@pytest.mark.parametrize(
    ("law", "said"),
    [(("willmore", {}), "W = 1/2 int H^2"), (("surface_diffusion", {}), "area A")],
)
def test_an_increase_of_the_energy_of_the_law_is_seen(law, said):
    name, parameters = law
    check = energy_decreases(made((3.0, 2.0, 2.0 + 1e-7, 1.0), name, **parameters))
    assert check.verdict == "fail" and "at t = 2" in check.text and said in check.text
    assert check.measured == pytest.approx(1e-7 / 3.0, rel=1e-6)
    assert energy_decreases(made((3.0, 2.0, 2.0 + 1e-12, 1.0), name)).verdict == "pass"
    assert energy_decreases(made((3.0,), name)).verdict == "pass"


@pytest.mark.parametrize("law", [HELFRICH, DIFFUSION], ids=["helfrich", "surface diffusion"])
def test_the_energy_of_every_law_is_written_checked_and_compared(command, tmp_path, law):
    """Of an ellipsoid, which is no umbilic surface; coarse, so that the bounds are wide."""
    reference = 'reference = "axisymmetric"\nreference_at = [0.02, 0.06]\nreference_within = 0.02'
    asked = ("energy_decreases = true", f"energy_decreases = true\n{reference}")
    path = write_flow(tmp_path, law, asked)
    status, out = command("flow", path, "--out", tmp_path / "out", "--no-pictures")
    flow = load_flow(path)
    symbol = flow.law.energy.symbol
    assert status == 0
    assert f"PASS  energy decreases: largest increase of the {flow.law.energy}" in out
    assert "PASS  W at t = 0.06: W = 2" in out and f"PASS  {symbol} at t = 0.06: {symbol} = " in out
    history = read_history(tmp_path / "out" / "small" / "history.csv", flow.law.energy)
    start = {"E": 6.9549, "A": 21.4784}[symbol]  # of the smooth ellipsoid, of revolution
    assert history.column("energy")[0] == pytest.approx(start, rel=0.03)
    assert history.column("willmore")[0] == pytest.approx(30.9032, rel=0.02)


def test_another_energy_than_that_of_the_law_fails_the_comparison(tmp_path):
    """What was compared before there was one energy a law: W with 1/2 int (H - H0)^2."""
    reference = 'reference = "axisymmetric"\nreference_at = [0.06]\nreference_within = 0.02'
    flow = load_flow(write_flow(tmp_path, HELFRICH, ("energy_decreases = true", reference)))
    history = History(flow.law.energy)
    exact = {"willmore": 28.7, "energy": 28.7, "area": 22.4}
    history.rows = [tuple(exact.get(name, 0.0) for name in COLUMNS)] * (flow.levels.steps + 1)
    ended = Ended({}, "ok", "", (), 0.0)
    verdicts = {c.name: c.verdict for c in checked(flow, ended, history, tmp_path)}
    assert (verdicts["W at t = 0.06"], verdicts["E at t = 0.06"]) == ("pass", "fail")


def test_a_reference_that_cannot_be_computed_is_refused_before_anything_is(command, tmp_path):
    """Negative spontaneous curvature makes the surface vanish before."""
    law = ('name = "willmore"', 'name = "helfrich"\nspontaneous_curvature = -4.0')
    reference = ("energy_decreases = true", 'reference = "axisymmetric"\nreference_at = [0.06]')
    path = write_flow(tmp_path, law, reference)
    status, out = command("flow", path, "--out", tmp_path / "out")
    said = " ".join(out.split())
    assert status == 2 and "Traceback" not in out
    assert "[checks] reference_at = 0.06: the axisymmetric solver does not get there" in said
    assert not (tmp_path / "out" / "small").exists()


class TestHistoriesOfBefore:
    """Files of versions that wrote W into the column of the energy."""

    def read(self, folder, law, **parameters):
        rows = [[f"{10.0 * t + i}" for i in range(len(BEFORE))] for t in (0.0, 1.0)]
        lines = [",".join(BEFORE), *(",".join(row) for row in rows)]
        (folder / "history.csv").write_text("\n".join(lines) + "\n")
        return read_history(folder / "history.csv", energy_of(law, **parameters))

    @pytest.mark.parametrize(
        ("law", "energy"), [("willmore", "willmore"), ("surface_diffusion", "area")]
    )
    def test_are_read_with_the_energy_of_the_law(self, tmp_path, law, energy):
        history = self.read(tmp_path, law)
        assert history.column("willmore").tolist() == [1.0, 11.0]
        assert history.column("area").tolist() == [2.0, 12.0]
        assert history.column("iterations").tolist() == [10.0, 20.0]
        np.testing.assert_array_equal(history.column("energy"), history.column(energy))

    def test_do_not_know_a_helfrich_energy(self, tmp_path):
        history = self.read(tmp_path, "helfrich", spontaneous_curvature=1.0)
        assert np.isnan(history.column("energy")).all()
        assert history.column("willmore").tolist() == [1.0, 11.0]

    def test_with_other_columns_or_short_lines_are_refused(self, tmp_path):
        path = tmp_path / "history.csv"
        path.write_text("t,energy\n0.0,1.0\n")
        with pytest.raises(ValueError, match="columns must be t, energy, willmore"):
            read_history(path, W)
        path.write_text(",".join(COLUMNS) + "\n0.0,1.0\n")
        with pytest.raises(ValueError, match=r"history\.csv: a line has not 13 entries"):
            read_history(path, W)


def test_a_flow_that_does_nothing_fails_the_checks_of_its_energy(command, tmp_path, monkeypatch):
    """The initial State at all levels never rises in energy; but it had to fall."""

    def resting(mesh, initial, scheme, levels, *_, **__):
        return (replace(initial, t=levels.t(n)) for n in range(levels.steps + 1))

    monkeypatch.setattr("esfem.schemes.kll.evolve", resting)
    status, out = command("flow", write_flow(tmp_path), "--out", tmp_path / "out", "--no-pictures")
    assert status == 1
    assert "PASS  energy decreases" in out and "FAIL  energy falls" in out


@pytest.mark.parametrize(("speed", "asked"), [(1e-6, False), (1.0, True)])
def test_only_of_a_surface_that_moves_the_energy_has_to_fall(speed, asked):
    history = History(energy_of("willmore"))
    for t in (0.0, 1.0):
        row = {"t": t, "energy": 25.0, "willmore": 25.0, "area": 12.6, "speed": speed}
        history.rows.append(tuple(row.get(name, 0.0) for name in COLUMNS))
    assert [check.verdict for check in energy_falls(history)] == ["fail"] * asked
