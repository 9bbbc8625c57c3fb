"""`esfem list`: the studies, surfaces, laws, claims and meshes there are."""

from esfem.common.console import plain_console


def list_() -> None:
    """List the studies, solutions, laws, claims and meshes there are.

    Example: `esfem list`
    """
    console = plain_console()
    for title, entries in overview().items():
        console.print(title, style="bold")
        width = max([20, *map(len, entries)])
        for name, text in entries.items():
            console.print(f"  {name:{width}} {text}", soft_wrap=True)


def overview() -> dict[str, dict[str, str]]:
    """What there is by the title of its list: names, and what they mean."""
    from esfem.meshes import MESH_SURFACES, committed_sizes
    from esfem.reference_solutions import STARTS
    from esfem.reference_solutions.surfaces import surface_names, surface_title
    from esfem.schemes import named_scheme, scheme_names
    from esfem.studies.case import ALL_LAWS, law_statement
    from esfem.studies.catalogue import study_sets
    from esfem.studies.claims import claims
    from esfem.studies.study import load_study

    sizes = {name: committed_sizes(name) for name in (*MESH_SURFACES, *surface_names())}
    return {
        **{
            title: {path.stem: load_study(path).study.title for path in paths}
            for title, paths in study_sets().items()
        },
        "solutions": {name: s.title for name, s in STARTS.items()},
        "surfaces (of solution surface)": {name: surface_title(name) for name in surface_names()},
        "laws": {name: law_statement(name) for name in ALL_LAWS},
        "schemes": {name: named_scheme(name).title for name in scheme_names()},
        "claims": {name: claim.statement for name, claim in claims().items()},
        "meshes": {name: "V = " + ", ".join(map(str, of)) for name, of in sizes.items() if of},
    }
