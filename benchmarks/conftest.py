"""What the file of results says of the machine, without names of hosts and folders."""

import importlib.metadata

from esfem.common.provenance import machine
from esfem.solver.threads import thread_count

PACKAGES = ("numpy", "scipy", "numba", "mkl", "pypardiso")


def pytest_benchmark_update_machine_info(config, machine_info: dict) -> None:
    """Machine, threads and versions instead of all that pytest-benchmark finds out."""
    machine_info.clear()
    machine_info["machine"], machine_info["threads"] = machine(), thread_count()
    machine_info.update({name: importlib.metadata.version(name) for name in PACKAGES})


def pytest_benchmark_update_json(config, benchmarks: list, output_json: dict) -> None:
    """No commit: the file is committed with the program that it is about."""
    output_json.pop("commit_info", None)
    for one in output_json["benchmarks"]:
        one["stats"].pop("data", None)
