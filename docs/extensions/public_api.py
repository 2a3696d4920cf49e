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
GROUPS: dict[str, tuple[str, str]] = {  # page: its title, and what stands at its head
    "vfife": (
        "What a first script needs",
        "A mechanism goes in, a result comes out; runs that belong together are a study.",
    ),
    "studies": (
        "vfife.studies",
        "Many runs of one question, kept in one file; tolerances, searches, slopes.",
    ),
    "dynamics": ("vfife.dynamics", "What becomes of a motion: sections, basins, waterfalls, modes, spectra."),
    "identification": (
        "vfife.identification and vfife.tribology",
        "Numbers of a model from measured curves; wear over many turns.",
    ),
    "bodies": ("vfife.bodies", "Links, rigid bodies, point masses, frames and their sections."),
    "joints": (
        "vfife.joints",
        "One class for each kind; ``Mechanism.revolute``, ``.slider``, ``.clearance_joint`` and so on make them.",
    ),
    "loads": ("vfife.springs, drivers and loads", "What holds, drives and loads the bodies."),
    "contact": (
        "vfife.laws: contact",
        "Normal forces. :doc:`Laws </laws>` has their equations, :doc:`the laws in pictures </laws-gallery>`"
        " their curves.",
    ),
    "friction": ("vfife.laws: friction", "Tangential forces."),
    "own": (
        "vfife.laws of one's own, options, errors",
        "What a law of one's own is made of, groups of keywords, and what is raised.",
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
        return "own" if inspect.ismodule(value) or name == "VfifeError" else "vfife"
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
