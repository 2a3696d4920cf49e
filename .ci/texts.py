"""Write the demo's answer into the README, the film and the figure that the README and the docs show, and the
lists of commands and of keys into their pages.

``make texts`` runs it; ``python .ci/texts.py lists`` writes the lists alone. ``tests/docs/test_readme.py``
compares the README with the demo, ``tests/docs/test_commands_named.py`` the lists with the package.
"""

import contextlib
import io
import re
import runpy
import sys
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


def lists() -> dict[Path, str]:
    """Return the pages of commands and of keys with the lists that the package has today."""
    sys.path.insert(0, str(ROOT / "docs" / "extensions"))
    try:
        import command_reference as commands
        import model_reference as keys
        from tables import with_lists
    finally:
        sys.path.pop(0)
    contents = {"commands.md": (commands.purposes(), commands.page()), "model-reference.md": (keys.page(),)}
    paths = {ROOT / "docs" / name: texts for name, texts in contents.items()}
    return {path: with_lists(path.read_text(encoding="utf-8"), *texts) for path, texts in paths.items()}


def main() -> None:
    """Write the lists, and what depends on the demo unless only lists are asked for."""
    for path, text in lists().items():
        path.write_text(text, encoding="utf-8")
        print(path.relative_to(ROOT))
    if sys.argv[1:] != ["lists"]:
        write_demo()


def write_demo() -> None:
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
