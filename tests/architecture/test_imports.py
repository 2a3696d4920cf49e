"""Who imports whom: rooms, what kernels may see, what is installed. The contract of layers itself is in
pyproject.toml and kept by the linter.
"""

from __future__ import annotations

import re
import sys

import pytest

from architecture.sources import PROJECT, ROOT, Import, files, imports, modules, parsed, report

KERNELS_MAY_IMPORT = {"numpy", *sys.stdlib_module_names}
EXTRAS = ("cluster", "gpu", "live", "optimise", "parquet", "sensitivity", "video")
# Declared, though no line imports it, and why.
NOT_IMPORTED = {
    "cuda-bindings": "imported by tests where pytest finds them",
    "distributed": "a cluster that the caller hands in; study asks nothing of it by name",
    "fonttools": "of matplotlib, held above a vulnerability",
    "h11": "of uvicorn, held above a vulnerability",
    "h5netcdf": "the engine that xarray is told to write with, by its name",
    "h5py": "what h5netcdf writes with",
    "nvidia-cuda-nvcc-cu12": "ptxas, a program",
    "nvidia-cuda-nvdisasm": "a program",
    "pytest-cov": "a plugin of pytest: make coverage",
    "pytest-xdist": "what `make test` runs its processes with, by an option",
    "tornado": "of distributed, held above a vulnerability",
    "urllib3": "of distributed, held above a vulnerability",
}
# Modules that are not called by the name that they are installed by.
IMPORTED_AS = {
    "PIL": "pillow",
    "bochscpu": "bochscpu-python",
    "cuda": "cuda-bindings",
    "xdist": "pytest-xdist",
}


@pytest.mark.system("starts a process")
def test_kernels_import_only_numpy_and_each_other() -> None:
    offenders = []
    for name, tree, _ in files():
        if not name.startswith("vfife/kernels/"):
            continue
        for one in imports(name, tree):
            inside = one.module == "vfife.kernels" or one.module.startswith("vfife.kernels.")
            if not inside and one.module.partition(".")[0] not in KERNELS_MAY_IMPORT:
                offenders.append(f"{name}:{one.line} imports {one.module}")
    report(
        "The kernels import the standard library, numpy and each other only; what compiles them is in"
        " compiler:",
        offenders,
    )


# ------------------------------------------------------------------------------------------------------ rooms


def levels() -> dict[str, int]:
    """Level of each room, the highest first, from the contract of layers."""
    (contract,) = (
        one for one in PROJECT["tool"]["importlinter"]["contracts"] if one["name"] == "packages are layers"
    )
    return {
        room.strip(): level for level, layer in enumerate(contract["layers"]) for room in layer.split("|")
    }


@pytest.mark.system("the contract of layers, which make lint keeps too")
def test_every_room_has_its_level() -> None:
    """A room that the contract of layers does not name may import what it likes."""
    rooms = {".".join(name.removesuffix(".py").split("/")[:2]) for name, _, _ in files()}
    report(
        "These rooms are in no layer of pyproject.toml:",
        sorted(rooms - levels().keys() - {"vfife.__init__", "vfife_validation.__init__"}),
    )


@pytest.mark.slow("parses every file")
def test_no_function_hides_an_import_of_a_room_above() -> None:
    level = levels()
    offenders = []
    for name, tree, _ in files():
        here = level.get(".".join(name.removesuffix(".py").split("/")[:2]))
        for one in imports(name, tree):
            there = level.get(".".join(one.module.split(".")[:2]))
            if here is not None and there is not None and one.inside and not one.for_types and there < here:
                offenders.append(f"{name}:{one.line} imports {one.module}")
    report("An import inside a function defers a cost, it does not turn the house upside down:", offenders)


def import_graph() -> dict[str, set[str]]:
    """Modules that each module imports, also inside functions, but not for type checkers alone."""
    graph: dict[str, set[str]] = {}
    for name, tree, _ in files():
        module = name.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
        graph[module] = {one.module for one in imports(name, tree) if not one.for_types} & modules()
    return graph


def cycles(graph: dict[str, set[str]]) -> list[list[str]]:
    """Sets of two or more modules each of which reaches all others: strongly connected components."""
    reached = {module: reach(graph, module) for module in graph}
    groups = {
        frozenset(other for other in others if module in reached[other]) for module, others in reached.items()
    }
    return sorted(sorted(group) for group in groups if len(group) > 1)


def reach(graph: dict[str, set[str]], start: str) -> set[str]:
    """The module and all that it imports, directly or not."""
    reached, waiting = {start}, [start]
    while waiting:
        for other in graph[waiting.pop()] - reached:
            reached.add(other)
            waiting.append(other)
    return reached


@pytest.mark.slow("parses every file")
def test_no_modules_import_each_other() -> None:
    """Counting imports inside functions. What two modules share belongs below both."""
    report(
        "These modules import each other; move what they share into one below:",
        [" ".join(group) for group in cycles(import_graph())],
    )


def test_a_cycle_is_seen() -> None:
    """One of three modules with a way in and a way out, and none where modules only share one."""
    graph = {"a": {"b"}, "b": {"c"}, "c": {"d", "e"}, "d": {"b"}, "e": set(), "f": {"e"}}
    assert cycles(graph) == [["b", "c", "d"]]
    graph["d"] = {"e"}
    assert cycles(graph) == []


# Packages that load numpy, or a compiler, or what draws: a command imports them where it needs them, so that
# every command starts at once and hears
# signals from its first line on. Everything else it imports at the top.
DEFERRED = (
    "assembly", "assessment", "cli.commands.law_drawing", "cli.commands.study",
    "dynamics", "identification", "job.cost", "laws", "live", "measures", "model",
    "modelfile", "plots", "report", "results.fit", "results.study", "schema", "simulation",
    "solvers.arguments", "solvers.companions", "solvers.transient", "store.connections", "store.runfile",
    "studies", "tribology", "units",
)  # fmt: skip


@pytest.mark.system("starts a process for each command")
def test_a_command_defers_only_what_takes_time_to_load() -> None:
    offenders = []
    for name, tree, _ in files():
        for one in imports(name, tree):
            ours = one.module.startswith("vfife.") and name.startswith("vfife/cli/")
            if not ours or not one.inside or one.for_types or name == "vfife/cli/app.py":
                continue
            module = one.module.removeprefix("vfife.")
            if not any(
                module == other or module.startswith(f"{other}.") for other in (*DEFERRED, "__version__")
            ):
                offenders.append(f"{name}:{one.line} imports {one.module}")
    report(
        "Imports inside functions of the command line are there for its start; these load at once, and belong"
        " at the top:",
        offenders,
    )


def test_an_import_inside_a_function_defers_something() -> None:
    """What loads with the file in any case is imported at its top."""
    inner: dict[str, list[Import]] = {}
    top: dict[str, set[str]] = {}
    for name, tree, _ in files():
        module = name.removesuffix(".py").replace("/", ".").removesuffix(".__init__")
        every = [one for one in imports(name, tree) if one.module.startswith("vfife") and not one.for_types]
        inner[module] = [one for one in every if one.inside]
        top[module] = {one.module for one in every if not one.inside}

    def loaded(module: str) -> set[str]:
        """Modules that load with this one, their packages among them."""
        result, left = set(), [module]
        while left:
            name = left.pop()
            if name in top and name not in result:
                result.add(name)
                left += [*top[name], name.rpartition(".")[0]]
        return result

    report(
        "These load with their files, and belong at the top:",
        [
            f"{module}:{one.line} imports {one.module}"
            for module, some in inner.items()
            for one in some
            # A file may ask its own package for what the package defines after having imported the file.
            if not f"{module}.".startswith(f"{one.module}.") and one.module in loaded(module)
        ],
    )


# --------------------------------------------------------------------------------------------------------
# what is installed


def requirements(*extras: str) -> set[str]:
    """Normal names of the distributions that the project declares, those of some extras too."""
    project = PROJECT["project"]
    lines, left = list(project["dependencies"]), list(extras)
    while left:
        for line in project["optional-dependencies"][left.pop()]:
            inner = re.fullmatch(r"vfife\[(.*)\]", line)
            left += inner[1].split(",") if inner else []
            lines += [] if inner else [line]
    return {normal(re.split(r"[\[<>=!~; ]", line, maxsplit=1)[0]) for line in lines}


def normal(name: str) -> str:
    """A distribution's name as registries compare it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def imported(folder: str) -> dict[str, str]:
    """Distributions that the files of a folder import, with a place of each. IMPORTED_AS has those of other
    names.
    """
    ours = {
        "vfife",
        "vfife_validation",
        *(
            path.stem
            for room in ("tests", "benchmarks", "docs/extensions")
            for path in (ROOT / room).iterdir()
        ),
    }
    found: dict[str, str] = {}
    for name, tree, _ in files() if folder == "src" else parsed(ROOT / folder):
        for one in imports(name, tree):
            top = one.module.partition(".")[0]
            if one.for_types:
                continue
            top = IMPORTED_AS.get(top, top)
            if top and top not in sys.stdlib_module_names and top not in ours:
                found.setdefault(normal(top), f"{name}:{one.line}")
    return found


@pytest.mark.system("parses every file of the project")
def test_what_the_package_imports_is_declared_and_what_is_declared_is_imported() -> None:
    declared, used = requirements(*EXTRAS), imported("src")
    report(
        "Imported, but not among the dependencies:",
        [f"{name} ({used[name]})" for name in sorted(used.keys() - declared)],
    )
    report("Installed, but never imported:", sorted(declared - used.keys() - NOT_IMPORTED.keys()))


@pytest.mark.system("parses every file of the tests")
def test_what_the_tests_import_is_declared_and_what_is_declared_is_imported() -> None:
    declared, used = requirements("test", "verify"), imported("tests")
    report(
        "Imported by tests, but not installed for them:",
        [f"{name} ({used[name]})" for name in sorted(used.keys() - declared)],
    )
    report(
        "Installed for tests, but never imported:",
        sorted(declared - requirements(*EXTRAS) - used.keys() - NOT_IMPORTED.keys()),
    )


def test_every_extra_is_for_work_on_the_package() -> None:
    """An extra comes with the code that imports what it brings."""
    assert set(PROJECT["project"]["optional-dependencies"]) == {*EXTRAS, "dev", "test", "verify"}
