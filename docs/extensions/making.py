"""What pages show and no page computes: live pages, drawings of mechanisms, curves of laws. Made by a process
of its own beside the rest of the build, `python docs/extensions/making.py FOLDER`, and made again only where
the package or an example has changed.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
MADE, EXTRA = "_made", "_made/extra"  # for pages, and what is copied into the output as it is
MARK = "made-of"


def made_of() -> str:
    """A hash of all that decides what is made."""
    found = hashlib.sha256()
    here = [Path(__file__).with_name(name) for name in ("making.py", "mechanisms.py", "law_gallery.py")]
    package = [path for path in (ROOT / "src").rglob("*") if path.is_file()]
    for path in sorted([*here, *package, *(ROOT / "examples").glob("*.toml")]):
        if "__pycache__" not in path.parts:
            found.update(path.relative_to(ROOT).as_posix().encode() + path.read_bytes())
    return found.hexdigest()


def live_page(name: str, folder: Path) -> None:
    """The page in which a mechanism runs, with its usual sliders."""
    from vfife import load
    from vfife.live import default_slides
    from vfife.live.page.page import live_page

    mechanism = load(ROOT / "examples" / f"{name}.toml")
    (folder / f"{name}.html").write_text(live_page(mechanism, default_slides(mechanism)), encoding="utf-8")


def bare(figure: Any) -> Any:
    """A drawing without axes, names and words, to be seen small."""
    figure.suptitle("")
    for axes in figure.axes:
        axes.set_axis_off()
        axes.set_title("")
        for text in [*axes.texts, *([axes.get_legend()] if axes.get_legend() else [])]:
            text.remove()
    for legend in list(figure.legends):
        legend.remove()
    return figure


def drawing(name: str, folder: Path) -> None:
    """The mechanism where it starts, to be seen small."""
    from vfife import load

    drawn = bare(load(ROOT / "examples" / f"{name}.toml").plot())
    drawn.savefig(folder / "pictures" / f"{name}.png", dpi=90, bbox_inches="tight")


def equilibria(name: str, folder: Path) -> None:
    """Those of a static analysis: its page and its figures, of one run."""
    from vfife import load, simulate
    from vfife.live.page.page import result_page

    result = simulate(load(ROOT / "examples" / f"{name}.toml"))
    (folder / Path(EXTRA).name / "live" / f"{name}.html").write_text(result_page(result), encoding="utf-8")
    for figure, drawn in result.plot().items():
        drawn.savefig(folder / f"{name}-{figure}.png", dpi=110)


def make(folder: Path) -> None:
    """Everything, into a folder."""
    import law_gallery

    from mechanisms import FAMILIES, model_of

    extra = folder / Path(EXTRA).name
    for one in ("live", "pictures"):
        (extra / one).mkdir(parents=True, exist_ok=True)
    every = [name for names in FAMILIES.values() for name in names]
    for number, name in enumerate(every, 1):
        print(f"live page {number} of {len(every)}: {name}", flush=True)
        drawing(name, extra)
        if model_of(name)[1]:
            equilibria(name, folder)
        else:
            live_page(name, extra / "live")
    law_gallery.pictures(folder / law_gallery.PICTURES)


RUNNING: list[subprocess.Popen[bytes]] = []


def begin(app: Any, config: Any) -> None:
    """Starts the process where anything has changed."""
    folder = Path(app.srcdir) / MADE
    (Path(app.srcdir) / EXTRA).mkdir(parents=True, exist_ok=True)
    mark = folder / MARK
    if not mark.exists() or mark.read_text(encoding="utf-8") != made_of():
        mark.unlink(missing_ok=True)
        paths = os.pathsep.join([str(ROOT / "src"), os.environ.get("PYTHONPATH", "")])
        RUNNING.append(
            subprocess.Popen([sys.executable, __file__, str(folder)], env={**os.environ, "PYTHONPATH": paths})
        )


def wait(app: Any) -> None:
    """Pages are read when everything is there."""
    for process in RUNNING:
        if process.wait():
            raise RuntimeError("docs/extensions/making.py failed; what it said stands above")
        (Path(app.srcdir) / MADE / MARK).write_text(made_of(), encoding="utf-8")
    RUNNING.clear()


def setup(app: Any) -> dict[str, bool]:
    app.connect("config-inited", begin)
    app.connect("builder-inited", wait, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


if __name__ == "__main__":
    make(Path(sys.argv[1]))
