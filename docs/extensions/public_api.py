"""The pages of public names, by namespace, and links of names in docstrings to them.

A name is found wherever a docstring says it: under the module that has it, or as it is imported.
"""

from __future__ import annotations

import inspect
import re
from functools import cache
from pathlib import Path
from typing import Any

FOLDER = "api"
GROUPS: dict[str, tuple[str, str]] = {  # page: its title, and the sentences at its head
    "vfife": (
        "vfife: mechanisms, runs, results",
        "Everything that a first script needs: build or load a mechanism, simulate it, read the result.",
    ),
    "bodies": ("vfife.bodies", "Links, rigid bodies, point masses, frames and their sections."),
    "joints": (
        "vfife.joints",
        "One class for each kind of joint. ``Mechanism.revolute``, ``Mechanism.slider``,"
        " ``Mechanism.clearance_joint`` and others create them.",
    ),
    "loads": ("vfife.springs, vfife.drivers, vfife.loads", "Springs, dampers, stops, drivers and loads."),
    "studies": (
        "vfife.studies",
        "Many runs of one mechanism: parameter studies, tolerances, fits, optimisation, sensitivities,"
        " comparison of laws.",
    ),
    "dynamics": (
        "vfife.dynamics",
        "Classification of motions, and frequencies: sections, bifurcation diagrams, basins, waterfalls,"
        " natural frequencies, spectra.",
    ),
    "identification": (
        "vfife.identification, vfife.tribology",
        "Parameters from measured curves, and wear over many turns.",
    ),
    "contact": (
        "vfife.laws: normal contact",
        "One class for each law. :doc:`Laws </laws>` has their equations, :doc:`the laws in pictures"
        " </laws-gallery>` their curves.",
    ),
    "friction": ("vfife.laws: friction", "One class for each law."),
    "own": (
        "Your own laws, options, errors",
        "Base classes of your own laws, groups of keyword arguments, and exceptions.",
    ),
}
ORDER = (
    "Mechanism",
    "simulate",
    "Result",
    "study",
    "load",
    "load_model",
    "save_model",
    "load_result",
    "resume",
)
SPACES = (
    "studies",
    "dynamics",
    "identification",
    "tribology",
    "bodies",
    "joints",
    "springs",
    "drivers",
    "loads",
    "laws",
)
PAGES = {
    "tribology": "identification",
    "springs": "loads",
    "drivers": "loads",
}  # of namespaces that share one
OPTIONS = ("Length", "Run", "Save", "Compute", "Watch")


@cache
def public() -> dict[str, Any]:
    """What the package offers: values by the names under which they are documented, each once."""
    import vfife

    found = {name: getattr(vfife, name) for name in vfife.__all__}
    seen = {id(value) for value in found.values()}
    for space in SPACES:
        module = getattr(vfife, space)
        for name in sorted(module.__all__):
            value = getattr(module, name)
            if id(value) not in seen:
                found[f"{space}.{name}"] = value
                seen.add(id(value))
    return found | {f"options.{name}": getattr(vfife.options, name) for name in OPTIONS}


def group_of(name: str, value: Any) -> str:
    """The page that a name is on."""
    space = name.rpartition(".")[0]
    if space == "laws":
        module = getattr(value, "__module__", "") or ""
        return next(
            (kind for kind in ("contact", "friction") if module.startswith(f"vfife.laws.{kind}")), "own"
        )
    if not space:
        return "own" if inspect.ismodule(value) or name in ("Interrupted", "VfifeError") else "vfife"
    return "own" if space == "options" else PAGES.get(space, space)


def by_group() -> dict[str, list[str]]:
    """The names of each page, in the order in which they are read."""
    found: dict[str, list[str]] = {group: [] for group in GROUPS}
    for name, value in public().items():
        found[group_of(name, value)].append(name)
    found["vfife"].sort(key=lambda name: (ORDER.index(name) if name in ORDER else len(ORDER), name))
    return found


def entry(name: str, value: Any) -> str:
    """How one name is documented."""
    if inspect.isclass(value):
        plain = issubclass(value, BaseException | dict)
        members = "" if plain else "   :members:\n   :inherited-members: object, str, int\n"
        return f".. autoclass:: vfife.{name}\n{members}"
    if inspect.ismodule(value):
        return (value.__doc__ or "").strip().splitlines()[0]
    if callable(value):
        return f".. autofunction:: vfife.{name}"
    return f"``vfife.{name}``: {', '.join(map(str, value))}"


def page(title: str, head: str, names: list[str]) -> str:
    """A page of names, in reStructuredText, as autodoc writes it."""
    values = public()
    entries = "\n\n".join(f"{name}\n{'-' * len(name)}\n\n{entry(name, values[name])}" for name in names)
    return f"{title}\n{'=' * len(title)}\n\n{head}\n\n{overview(names)}\n\n{entries}\n"


KINDS = ("Functions", "Classes", "Submodules and values")


def kind_of(value: Any) -> str:
    """The group of a name in the overview of its page."""
    if inspect.isclass(value):
        return "Classes"
    return "Functions" if callable(value) else "Submodules and values"


def summary(value: Any) -> str:
    """The first sentence of a docstring, as text."""
    if not (inspect.isclass(value) or inspect.ismodule(value) or callable(value)):
        return "Predefined values."
    if words := getattr(value, "__args__", ()):
        return f"One of {', '.join(f'``{word!r}``' for word in words)}."
    first = (inspect.getdoc(value) or "").split("\n\n")[0]
    sentence = re.split(r"(?<=[.:])\s+(?=[A-Z`])", " ".join(first.split()), maxsplit=1)[0]
    sentence = sentence.removesuffix(":").rstrip(".") + "."
    return paragraph([re.sub(r":\w+:`[~.]*([^`<]+?)(?: <[^`]*>)?`", r"``\1``", sentence)])


def overview(names: list[str]) -> str:
    """A table for each kind of name on a page: the name, which leads to its entry, and a sentence."""
    values = public()
    parts = []
    for kind in KINDS:
        chosen = [name for name in names if kind_of(values[name]) == kind]
        if chosen:
            rows = "".join(f"   * - `{name}`_\n     - {summary(values[name])}\n" for name in chosen)
            parts.append(f".. rubric:: {kind}\n\n.. list-table::\n   :widths: 30 70\n\n{rows}")
    return "\n".join(parts)


def write_pages(app: Any) -> None:
    """A page for each group, laid anew where it differs."""
    folder = Path(app.srcdir) / FOLDER
    folder.mkdir(exist_ok=True)
    wanted = {f"{group}.rst": page(*GROUPS[group], names) for group, names in by_group().items()}
    for stale in {path.name for path in folder.iterdir()} - set(wanted):
        (folder / stale).unlink()
    for name, text in wanted.items():
        if not (folder / name).exists() or (folder / name).read_text(encoding="utf-8") != text:
            (folder / name).write_text(text, encoding="utf-8")


CODE = re.compile(r"(:\w+:`[^`]+`|``[^`]+``)")
LAID_OUT = re.compile(r"^\s|\S  +\S|^>>>")  # a line whose blanks mean something, or which is typed


NAMED = re.compile(r"(\w+(?:, \w+)*): ")  # a line that says what an argument is


def listed(lines: list[str]) -> list[str]:
    """Lines that say what arguments are, as a list."""
    items: list[list[str]] = []
    for line in lines:
        if NAMED.match(line):
            items.append([NAMED.sub(r"``\1``: ", line, count=1)])
        else:
            items[-1].append(line)
    return [f"* {paragraph(item)}" for item in items]


def paragraph(lines: list[str]) -> str:
    """Prose, in which signs are signs; code and references stay what they are."""
    parts = CODE.split(" ".join(line.strip() for line in lines))
    return "".join(part if k % 2 else re.sub(r"([\\`*_|])", r"\\\1", part) for k, part in enumerate(parts))


def read_as_text(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """A docstring is text, whose paragraphs are set as such; what is laid out or typed stands as it is."""
    parts: list[list[str]] = [[]]
    for line in lines:
        if line.strip():
            parts[-1].append(line.rstrip())
        elif parts[-1]:
            parts.append([])
    told: list[str] = []
    for k, part in enumerate(part for part in parts if part):
        if sum(bool(NAMED.match(line)) for line in part) > 1 and NAMED.match(part[0]):
            told += [*listed(part), ""]
        elif k and any(LAID_OUT.search(line) for line in part):
            language = "python" if part[0].startswith(">>>") else "text"
            told += [f".. code-block:: {language}", "", *(f"   {line}" for line in part), ""]
        else:
            told += [paragraph(part), ""]
    lines[:] = told


def found_under_its_import(app: Any, env: Any, node: Any, contnode: Any) -> Any:
    """A reference to a name in its module, led to where it is documented: as imported from the package."""
    if node.get("refdomain") != "py":
        return None
    last = node["reftarget"].rsplit(".", 1)[-1]
    target = next(
        (f"vfife.{name}" for name in public() if name.rpartition(".")[2] == last), node["reftarget"]
    )
    if target == node["reftarget"]:
        return None
    return env.domains["py"].resolve_xref(
        env, node["refdoc"], app.builder, node["reftype"], target, node, contnode
    )


def setup(app: Any) -> dict[str, bool]:
    app.connect("builder-inited", write_pages)
    app.connect("autodoc-process-docstring", read_as_text)
    app.connect("missing-reference", found_under_its_import)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
