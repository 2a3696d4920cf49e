"""Equations as MathML, made while the pages are built, with a font for them in the style sheet: pages ask for
nothing elsewhere.

Sphinx' own renderers send the reader to a content network, or need LaTeX. The font is laid into the page's
styles and not beside them, since browsers refuse fonts from another folder where pages are opened from disk.
"""

from __future__ import annotations

import base64
import io
import logging
from importlib.resources import files
from pathlib import Path
from typing import Any

from math_core import LatexToMathML

STYLE = "equations.css"
SIGNS = "()[]{}|√∑∫−+=<>≤≥≠±∓·×÷∞′″∂∇→⋅⟨⟩‖¨˙ˆ¯˜"  # drawn as parts of other signs, or made of a command


def mathml(latex: str, block: bool) -> str:
    """An equation as MathML. Raises ``math_core.LatexError`` for what it does not know."""
    return LatexToMathML().convert_with_local_state(latex.strip(), displaystyle=block)


def inline(self: Any, node: Any) -> None:
    """An equation in a line."""
    self.body.append(f'<span class="math">{mathml(node.astext(), False)}</span>')
    raise_skip()


def block(self: Any, node: Any) -> None:
    """An equation on a line of its own, which scrolls where the screen is narrower."""
    self.body.append(self.starttag(node, "div", CLASS="math"))
    self.body.append(mathml(node.astext(), True) + "</div>\n")
    raise_skip()


def raise_skip() -> None:
    """The node is written; what is in it is not."""
    from docutils import nodes

    raise nodes.SkipNode


def shown() -> set[int]:
    """Every sign that an equation may have: ASCII, Greek, their slanted and bold forms, operators and
    brackets.
    """
    from fontTools.ttLib import TTFont

    held = set(TTFont(font_file(), lazy=True).getBestCmap())
    wanted = {
        *range(0x20, 0x7F),
        *range(0x391, 0x3F7),
        *range(0x1D400, 0x1D468),
        *range(0x1D6A8, 0x1D71C),
        0x210E,
        0x2061,
        0x2063,
    }
    return held & (wanted | set(map(ord, SIGNS)))


def font_file() -> str:
    """STIX Two Math (SIL Open Font License), as ziamath brings it."""
    return str(files("ziamath") / "fonts" / "STIXTwoMath-Regular.ttf")


def style() -> str:
    """A style sheet with the part of the font that equations use, its table of mathematics with it."""
    from fontTools import subset

    logging.getLogger("fontTools").setLevel(logging.WARNING)
    options = subset.Options(
        flavor="woff", layout_features=["ssty", "dtls", "flac", "kern", "mark", "ccmp"], notdef_outline=True
    )
    font = subset.load_font(font_file(), options)
    cutter = subset.Subsetter(options)
    cutter.populate(unicodes=shown())
    cutter.subset(font)
    packed = io.BytesIO()
    subset.save_font(font, packed, options)
    text = base64.b64encode(packed.getvalue()).decode("ascii")
    face = (
        f'@font-face {{ font-family: "Equations"; src: url("data:font/woff;base64,{text}") format("woff"); }}'
    )
    return f'{face}\nmath {{ font-family: "Equations", math; }}\n'


def write_style(app: Any, error: Exception | None) -> None:
    """Lays the style sheet beside the others."""
    if error is None and app.builder.format == "html":
        folder = Path(app.outdir) / "_static"
        folder.mkdir(exist_ok=True)
        if not (folder / STYLE).exists():
            (folder / STYLE).write_text(style(), encoding="utf-8")


def setup(app: Any) -> dict[str, bool]:
    app.add_html_math_renderer("mathml", inline_renderers=(inline, None), block_renderers=(block, None))
    app.connect("build-finished", write_style)
    app.connect("builder-inited", lambda app: app.add_css_file(STYLE))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
