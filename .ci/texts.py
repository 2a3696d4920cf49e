"""Write the demo's answer into the README, and the film and the figure that the README and the docs show.

``make texts`` runs it; ``tests/docs/test_readme.py`` compares the README with the demo.
"""

import contextlib
import io
import re
import runpy
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "_static"
BLOCK = re.compile(r"(<!-- demo:[^\n]*-->\n```text\n).*?(```\n<!-- end of demo -->)", re.S)
FRAMES, RATE = 120, 20  # of the film: one turn in six seconds
WIDTH = 760  # pixels of the film


def demo() -> tuple[str, dict[str, object]]:
    """Run the demo; return what it prints and its names."""
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        names = runpy.run_path(str(ROOT / "examples" / "compressor.py"), run_name="__main__")
    return "\n".join(line.rstrip() for line in printed.getvalue().strip().splitlines()), names


def shrink(film: Path) -> None:
    """Make a film smaller: fewer pixels, the palette of its first frame for all."""
    with Image.open(film) as source:
        palette, frames = source.copy(), []
        for number in range(source.n_frames):
            source.seek(number)
            frame = source.convert("RGB")
            size = (WIDTH, round(WIDTH * frame.height / frame.width))
            frames.append(frame.resize(size, Image.Resampling.LANCZOS))
    first, *others = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    first.save(film, save_all=True, append_images=others, duration=1000 // RATE, loop=0, optimize=True)


def main() -> None:
    """Run the demo and write what depends on it."""
    printed, names = demo()
    readme = ROOT / "README.md"
    text, count = BLOCK.subn(
        lambda match: f"{match[1]}{printed}\n{match[2]}", readme.read_text(encoding="utf-8")
    )
    if count != 1:
        raise SystemExit("README.md: expected one block between <!-- demo: ... --> and <!-- end of demo -->")
    readme.write_text(text, encoding="utf-8")
    film = PICTURES / "compressor.gif"
    names["results"]["worn"].animate(film, frames=FRAMES, rate=RATE)
    shrink(film)
    figure = PICTURES / "compressor-force.png"
    names["comparison"].savefig(figure, dpi=120)
    with Image.open(figure) as picture:
        picture.convert("RGB").quantize(64).save(figure, optimize=True)
    for path in (readme, film, figure):
        print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
