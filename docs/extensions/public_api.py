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
    "mechanism": ("Mechanism and bodies", "What a mechanism is built of. Its builders take numbers in SI units, or texts with their unit."),
    "joints": ("Joints", "One class for each kind; `Mechanism.revolute`, `.slider`, `.clearance` and so on make them."),
    "loads": ("Springs, drivers and loads", "What holds, drives and loads the bodies."),
    "contact": ("Contact laws", "Normal forces. [Laws](../laws.md) has their equations, the [gallery of laws](../laws-gallery.md) their curves."),
    "friction": ("Friction laws", "Tangential forces."),
    "own": ("Laws of one's own, materials, errors", "What a law of one's own is made of, and what is raised."),
}
RUNNING = ("simulate", "Result", "load_result", "resume", "ensemble", "compare", "Comparison", "Simulation", "modes", "Status")
MECHANISM = (
    "Mechanism", "Settings", "StartSettings", "Link", "RigidBody", "PointMass", "Frame", "Member", "Section", "load", "load_model", "save_model",
)  # fmt: skip
ROOMS = {"vfife.laws.contact": "contact", "vfife.laws.friction": "friction", "vfife.model.joints": "joints"}


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
    return "loads" if module.startswith(("vfife.model.springs", "vfife.model.drivers", "vfife.model.loads")) else "own"


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
        members = "" if issubclass(value, BaseException) else ":members:\n:inherited-members: object, str, int\n"
        return f"```{{autoclass}} vfife.{name}\n{members}```\n"
    if inspect.ismodule(value):
        return f"`vfife.{name}`\n: {(value.__doc__ or '').strip().splitlines()[0]}\n"
    if callable(value):
        return f"```{{autofunction}} vfife.{name}\n```\n"
    return f"`vfife.{name}`\n: {', '.join(map(str, value))}\n"


def write_pages(app: Any) -> None:
    """A page for each group, laid anew where it differs."""
    folder = Path(app.srcdir) / FOLDER
    folder.mkdir(exist_ok=True)
    values, wanted = public(), {}
    for group, names in by_group().items():
        title, head = GROUPS[group]
        body = "\n".join(f"## {name}\n\n{entry(name, values[name])}" for name in names)
        wanted[f"{group}.md"] = f"# {title}\n\n{head}\n\n{body}"
    for stale in {path.name for path in folder.iterdir()} - set(wanted):
        (folder / stale).unlink()
    for name, text in wanted.items():
        if not (folder / name).exists() or (folder / name).read_text(encoding="utf-8") != text:
            (folder / name).write_text(text, encoding="utf-8")


def layout_kept(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Shows a docstring as plain text, whose layout carries meaning: the summary, then the rest as it stands."""
    text = [line.rstrip() for line in lines]
    while text and not text[-1]:
        text.pop()
    end = text.index("") if "" in text else len(text)
    summary, rest = text[:end], text[end:]
    parts = re.split(r"(:\w+:`[^`]+`|``[^`]+``)", " ".join(line.strip() for line in summary))
    escaped = "".join(part if part.startswith(("``", ":")) and part.endswith("`") else re.sub(r"([\\`*_|])", r"\\\1", part) for part in parts)
    lines[:] = [escaped, ""]
    if any(rest):
        plain = (re.sub(r":\w+:`~?(?:[\w.]+\.)?(\w+)`", r"\1", line) for line in rest)
        lines += [".. code-block:: text", "", *(f"   {line}" if line else "" for line in plain), ""]


def found_under_its_import(app: Any, env: Any, node: Any, contnode: Any) -> Any:
    """A reference to a name in its module, led to where it is documented: as imported from the package."""
    if node.get("refdomain") != "py":
        return None
    last = node["reftarget"].rsplit(".", 1)[-1]
    target = f"vfife.{last}"
    if target == node["reftarget"] or last not in public():
        return None
    return env.domains["py"].resolve_xref(env, node["refdoc"], app.builder, node["reftype"], target, node, contnode)


def setup(app: Any) -> dict[str, bool]:
    app.connect("builder-inited", write_pages)
    app.connect("autodoc-process-docstring", layout_kept)
    app.connect("missing-reference", found_under_its_import)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
