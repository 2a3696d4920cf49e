"""The pages of what `from vfife import` offers, by what it is for, and links of names in docstrings to them.

A name is found wherever a docstring says it: under the module that has it, or as it is imported.
"""

from __future__ import annotations

import inspect
import re
from pathlib import Path
from typing import Any

FOLDER = "api"
GROUPS: dict[str, tuple[str, str]] = {  # page: its title, and what stands at its head
    "running": ("Simulate", "A mechanism goes in, a result comes out; or it is stepped from outside."),
    "studies": (
        "Studies",
        "Many runs of one question, kept in one file; tolerances, searches, slopes; bifurcations, sections and basins; wear.",
    ),
    "mechanism": (
        "Mechanism and bodies",
        "What a mechanism is built of. Its builders take numbers in SI units, or texts with their unit.",
    ),
    "joints": (
        "Joints",
        "One class for each kind; ``Mechanism.revolute``, ``.slider``, ``.clearance`` and so on make them.",
    ),
    "loads": ("Springs, drivers and loads", "What holds, drives and loads the bodies."),
    "contact": (
        "Contact laws",
        "Normal forces. :doc:`Laws </laws>` has their equations, :doc:`the laws in pictures </laws-gallery>` their curves.",
    ),
    "friction": ("Friction laws", "Tangential forces."),
    "own": (
        "Laws of one's own, materials, errors",
        "What a law of one's own is made of, and what is raised.",
    ),
}
RUNNING = (
    "simulate", "Result", "load_result", "resume", "ensemble", "compare", "Comparison", "Simulation", "modes", "fit", "Status",
    "spectrum", "spectrogram", "envelope",
)  # fmt: skip
MECHANISM = (
    "Mechanism", "Settings", "StartSettings", "Link", "RigidBody", "PointMass", "Frame", "Member", "Section", "load", "load_model", "save_model",
)  # fmt: skip
ROOMS = {
    "vfife.study": "studies",
    "vfife.results.studied": "studies",
    "vfife.laws.contact": "contact",
    "vfife.laws.friction": "friction",
    "vfife.model.joints": "joints",
    "vfife.model.wear": "joints",
}


def public() -> dict[str, Any]:
    """What the package offers, by name."""
    import vfife

    return {name: getattr(vfife, name) for name in sorted(vfife.__all__)}


def group_of(name: str, value: Any) -> str:
    """The page that a name is on."""
    if name in RUNNING:
        return "running"
    if name in MECHANISM:
        return "mechanism"
    module = getattr(value, "__module__", "") or ""
    room = next((group for start, group in ROOMS.items() if module.startswith(start)), "")
    if room:
        return room
    return (
        "loads"
        if module.startswith(("vfife.model.springs", "vfife.model.drivers", "vfife.model.loads"))
        else "own"
    )


def by_group() -> dict[str, list[str]]:
    """The names of each page, in the order in which they are read."""
    found: dict[str, list[str]] = {group: [] for group in GROUPS}
    for name, value in public().items():
        found[group_of(name, value)].append(name)
    for group, order in (("running", RUNNING), ("mechanism", MECHANISM)):
        found[group].sort(key=lambda name: order.index(name))
    return found


def entry(name: str, value: Any) -> str:
    """How one name is told."""
    if inspect.isclass(value):
        members = (
            ""
            if issubclass(value, BaseException)
            else "   :members:\n   :inherited-members: object, str, int\n"
        )
        return f".. autoclass:: vfife.{name}\n{members}"
    if inspect.ismodule(value):
        return (value.__doc__ or "").strip().splitlines()[0]
    if callable(value):
        return f".. autofunction:: vfife.{name}"
    return f"``vfife.{name}``: {', '.join(map(str, value))}"


def page(title: str, head: str, names: list[str]) -> str:
    """A page of names, in reStructuredText, as autodoc writes it."""
    values = public()
    told = "\n\n".join(f"{name}\n{'-' * len(name)}\n\n{entry(name, values[name])}" for name in names)
    return f"{title}\n{'=' * len(title)}\n\n{head}\n\n{told}\n"


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


NAMED = re.compile(r"(\w+): ")  # a line that says what an argument is


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
    target = f"vfife.{last}"
    if target == node["reftarget"] or last not in public():
        return None
    return env.domains["py"].resolve_xref(
        env, node["refdoc"], app.builder, node["reftype"], target, node, contnode
    )


def setup(app: Any) -> dict[str, bool]:
    app.connect("builder-inited", write_pages)
    app.connect("autodoc-process-docstring", read_as_text)
    app.connect("missing-reference", found_under_its_import)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
