"""Films as files: GIF by Pillow, MP4 by the ffmpeg of imageio-ffmpeg; complete or not there."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, cast

from PIL import Image, ImageColor

from ..errors import StorageError, VfifeError
from ..files import replacement
from ..results.run_data import RunData
from .film import Film
from .style import BODIES, FAINT, GREY, INK, ORANGE, VERMILION

Progress = Callable[[int, int], None] | None  # frames that are done, and all frames
FILMS = (".gif", ".mp4")
PIXELS = {".gif": 96.0, ".mp4": 128.0}  # an inch: 960 by 540 and 1280 by 720
MOST_FRAMES = 3000
EXTRA = (
    'MP4 is written by imageio-ffmpeg, which is not installed here: pip install "vfife[video]", or write .gif'
    ' (in a folder of the source code: pip install ".[video]")'
)
# Lighter shades (of 255) become white; the coarse table of colours would make the paper grey.
NEAR_WHITE = 240
SHORTEST = 3.0  # s that a film of equilibria takes, if each is shown for no more than a second
SHADES = 8  # of each colour in the palette of a GIF, for soft edges


def animate(
    result: RunData,
    path: Path,
    frames: int = 240,
    rate: float = 25.0,
    turns: float = 1.0,
    progress: Progress = None,
    reference: RunData | None = None,
) -> tuple[int, float]:
    """Write a film of the last ``turns`` turns, of the whole run without a crank; return its number of frames
    and its length (s).

    It has ``frames`` frames, at most one for each output, ``rate`` of them a second; few equilibria are shown
    more slowly. ``progress`` is called after each. Raises VfifeError for another ending, numbers out of
    range, and MP4 without imageio-ffmpeg; StorageError or OSError where the file cannot be written.
    """
    kind = path.suffix.lower()
    if kind not in FILMS:
        raise VfifeError(
            f'{path}: no film is written as "{path.suffix or path.name}"; endings that say a format are'
            f" {', '.join(FILMS)}"
        )
    for name, value, low, high in (
        ("frames", frames, 2, MOST_FRAMES),
        ("frames a second", rate, 1, 50),
        ("turns", turns, 1e-3, 1e4),
    ):
        if not low <= value <= high:
            raise VfifeError(f"{path}: {name}: {value:g} is not between {low:g} and {high:g}")
    program = _ffmpeg(path) if kind == ".mp4" else ""
    if len(result.record.steps) < 2:
        raise VfifeError(f"{path}: this run has one output, so that nothing moves; run it for longer")
    film = Film(result, reference if reference is not None else result.reference, frames, turns, PIXELS[kind])
    if result.record.static:
        rate = min(rate, max(1.0, film.frames / SHORTEST))
    with replacement(path) as part:
        if kind == ".gif":
            _gif(film, part, rate, progress)
        else:
            _mp4(film, path, part, rate, progress, program)
    return film.frames, film.frames / rate


def _ffmpeg(path: Path) -> str:
    try:
        import imageio_ffmpeg
    except ImportError:
        raise VfifeError(f"{path}: {EXTRA}") from None
    try:
        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except RuntimeError as error:
        raise VfifeError(f"{path}: imageio-ffmpeg finds no ffmpeg here ({error}); write .gif") from error


def _mp4(film: Film, path: Path, part: Path, rate: float, progress: Progress, program: str) -> None:
    """H.264 in the colours that every player shows. Ctrl-C does not reach the encoder: it is ended here."""
    width, height = film.size
    source = f"-y -v error -f rawvideo -pix_fmt rgba -s {width}x{height} -r {rate:g} -i - -an"
    target = "-c:v libx264 -preset veryfast -crf 20 -pix_fmt yuv420p -movflags +faststart -f mp4"
    with TemporaryFile() as errors:
        line = [program, *source.split(), *target.split(), str(part.absolute())]
        encoder = subprocess.Popen(
            line, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=errors, start_new_session=True
        )
        try:
            # A broken pipe means that ffmpeg has ended; its last message is reported below.
            with suppress(BrokenPipeError), cast("IO[bytes]", encoder.stdin) as pipe:
                for k, picture in enumerate(film.pictures(), 1):
                    pipe.write(picture.data)
                    if progress is not None:
                        progress(k, film.frames)
            code = encoder.wait()
        except BaseException:
            encoder.kill()
            encoder.wait()
            raise
        if code:
            raise StorageError(f"{path}: ffmpeg could not write the film: {_last_line(errors)}.")


def _last_line(errors: IO[bytes]) -> str:
    errors.seek(0)
    lines = errors.read().decode("utf-8", "replace").split("\n")
    return next(
        (line.strip().rstrip(".") for line in reversed(lines) if line.strip()), "it ended without a word"
    )


def _gif(film: Film, part: Path, rate: float, progress: Progress) -> None:
    """Frames with one palette; a GIF counts time in hundredths of a second."""
    palette = _palette()

    def frames() -> Iterator[Image.Image]:
        for k, picture in enumerate(film.pictures(), 1):
            image = Image.frombuffer("RGBA", film.size, picture, "raw", "RGBA", 0, 1).convert("RGB")
            yield image.quantize(palette=palette, dither=Image.Dither.NONE)
            if progress is not None:
                progress(k, film.frames)

    images = frames()
    lasting = 10 * max(2, round(100.0 / rate))  # ms; less than two hundredths are shown slowly
    next(images).save(
        part, format="GIF", save_all=True, append_images=images, duration=lasting, loop=0, optimize=False
    )


def _palette() -> Image.Image:
    """Return the colours that figures are drawn in, in shades towards white, and those of bodies
    towards ink.
    """
    colours: list[tuple[int, ...]] = []
    for name in dict.fromkeys((INK, GREY, FAINT, ORANGE, VERMILION, *BODIES)):
        colours += _shades(ImageColor.getrgb(name), (255, 255, 255))
    for name in BODIES:
        colours += _shades(ImageColor.getrgb(name), ImageColor.getrgb(INK))
    image = Image.new("P", (1, 1))
    shades = [(255, 255, 255), *(colour for colour in dict.fromkeys(colours) if min(colour) < NEAR_WHITE)]
    flat = [part for colour in shades for part in colour]
    image.putpalette((flat + [255] * 768)[:768])
    return image


def _shades(of: tuple[int, ...], towards: tuple[int, ...]) -> list[tuple[int, ...]]:
    return [
        tuple(round(a + (b - a) * k / SHADES) for a, b in zip(of, towards, strict=True))
        for k in range(SHADES + 1)
    ]
