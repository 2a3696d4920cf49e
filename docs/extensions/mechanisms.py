"""The gallery: a page for each model file of examples/, live, with figures where it rests; a first page with
all of them.
"""

from __future__ import annotations

import re
import tomllib
from html import escape
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
MODELS = ROOT / "examples"
FAMILIES = {
    "Machines": (
        "compressor",
        "six_bar_press",
        "quick_return",
        "scotch_yoke",
        "jansen_leg",
        "jansen_leg_loose",
        "scissor_lift",
        "gear_train",
        "squeezer",
        "toggle_press",
    ),
    "Slider-cranks": (
        "slider_crank",
        "slider_crank_loose_pin",
        "slider_crank_loose_guide",
        "slider_crank_free",
        "piston_slap",
    ),
    "Four-bars": ("four_bar", "four_bar_case_b", "four_bar_case_c", "four_bar_ideal", "four_bar_loose"),
    "Small examples": ("journal_in_bearing", "block_on_incline", "double_pendulum", "elastic_pendulum"),
    "Static analyses": ("elastica_circle", "williams_toggle", "lee_frame"),
}
LIVE = """```{raw} html
<iframe class="live" src="../live/NAME.html" title="TITLE, running" loading="lazy"></iframe>
<p class="below">HINT <a href="../live/NAME.html">Open it on a page of its own</a> for more room.</p>
```

[Live pages](../live.md) describes everything that the page can do.
"""
AT_REST = """```{image} ../_made/NAME-mechanism.png
:class: drawn
:alt: drawing of the mechanism under its loads
```

```{image} ../_made/NAME-SECOND.png
:class: drawn
:alt: forces or moments in its joints over the load factor
```
"""
HINTS = {False: "Move a slider, or click a joint.", True: "The slider moves along the load path."}
SECOND = {"elastica_circle": "moments"}  # the figure beside the mechanism at rest; forces of others
PAGE = """# TITLE

TEXT

SHOWN
## Run it

```console
$ vfife run examples/NAME.toml --figures
$ vfife live examples/NAME.toml -o NAME.html
```

In Python, `vfife.gallery.NAME()` returns the mechanism, with some of its numbers as arguments.
`vfife.gallery.load("NAME", {...})` changes any number by its path.

## Model file

```{literalinclude} ../../examples/NAME.toml
:language: toml
```
"""


def head_of(name: str) -> list[str]:
    """The paragraphs of the comment at the head of a model file."""
    lines = (MODELS / f"{name}.toml").read_text(encoding="utf-8").splitlines()
    end = next(k for k, line in enumerate(lines) if not line.startswith("#"))
    return [
        part.replace("\n", " ") for part in "\n".join(line[1:].strip() for line in lines[:end]).split("\n\n")
    ]


def prose(text: str) -> str:
    """The same in Markdown: what is typed is set as code, and signs that mean something there are signs."""
    parts = re.split(r"""(--set [\w.-]+=(?:"[^"]*"|[\d.]*\d)(?: --set [\w.-]+=[\d.]*\d)*)""", text)
    return "".join(
        f"`{part}`" if k % 2 else re.sub(r"([*_<|\\$`])", r"\\\1", part) for k, part in enumerate(parts)
    )


def model_of(name: str) -> tuple[str, bool]:
    """The title of a model, and whether it is one of statics."""
    model = tomllib.loads((MODELS / f"{name}.toml").read_text(encoding="utf-8"))
    return model["name"][0].upper() + model["name"][1:], model.get("run", {}).get("analysis") == "static"


def page(name: str) -> str:
    """The page of a mechanism."""
    title, static = model_of(name)
    shown = LIVE.replace("HINT", HINTS[static]) + ("\n" + AT_REST if static else "")
    text = PAGE.replace("TEXT", "\n\n".join(map(prose, head_of(name)))).replace("SHOWN", shown)
    return text.replace("TITLE", title).replace("SECOND", SECOND.get(name, "forces")).replace("NAME", name)


def card(name: str) -> str:
    """A mechanism on the first page: its picture, and what the first line of its file says."""
    title, first = escape(model_of(name)[0]), escape(head_of(name)[0])
    picture = f'<img src="../pictures/{name}.png" alt="" loading="lazy">'
    return f'<a class="card" href="{name}.html">{picture}<b>{title}</b><span>{first}</span></a>'


def first_page() -> str:
    """All mechanisms by family."""
    found = {path.stem for path in MODELS.glob("*.toml")}
    listed = [name for names in FAMILIES.values() for name in names]
    if found != set(listed):
        raise RuntimeError(
            f"docs/extensions/mechanisms.py has no family for {sorted(found ^ set(listed))}, or a family "
            f"has no file"
        )
    parts = [
        "# Gallery",
        "Mechanisms to start from. Each runs on its page, and is a model file in `examples` and a function "
        "of `vfife.gallery`.",
    ]
    for family, names in FAMILIES.items():
        cards = "\n".join(map(card, names))
        parts.append(f'## {family}\n\n```{{raw}} html\n<div class="cards">\n{cards}\n</div>\n```')
    return "\n\n".join([*parts, "\n".join(["```{toctree}", ":hidden:", "", *listed, "```"])]) + "\n"


def write_pages(app: Any) -> None:
    """The folder gallery/, laid anew where it differs."""
    folder = Path(app.srcdir) / "gallery"
    folder.mkdir(exist_ok=True)
    wanted = {"index.md": first_page()} | {
        f"{name}.md": page(name) for names in FAMILIES.values() for name in names
    }
    for stale in {path.name for path in folder.iterdir()} - set(wanted):
        (folder / stale).unlink()
    for name, text in wanted.items():
        if not (folder / name).exists() or (folder / name).read_text(encoding="utf-8") != text:
            (folder / name).write_text(text, encoding="utf-8")


def setup(app: Any) -> dict[str, bool]:
    app.connect("builder-inited", write_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
