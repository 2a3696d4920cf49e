"""``vfife live``: a page in which a mechanism runs, as a file or served with Python behind it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ...files import write_text as kept
from ...store.schemas import is_run_file
from ..options import LawsOption, SetOption, overrides, take_laws
from ..signals import NOW, end_at_once
from ..terminal import amount_of_bytes, fail, sentences, tell, writing

SOURCE = (
    "Model file, or the folder of a run, whose step it takes; without one the page begins at the gallery."
)
Source = Annotated[Path | None, typer.Argument(metavar="MODEL|RUN", help=SOURCE, show_default=False)]
Out = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", metavar="PAGE.html", help="Write a page that needs no server.", show_default=False
    ),
]
SLIDE = (
    "Make this number a slider, from and to, as in joint.C.clearance=0.01..0.5mm; others than these there are"
    " none then."
)
Slide = Annotated[list[str] | None, typer.Option("--slide", metavar="PATH=LOW..HIGH", help=SLIDE)]
NoSlide = Annotated[bool, typer.Option("--no-sliders", help="Without any slider.")]
Port = Annotated[
    int,
    typer.Option(
        "--port", metavar="N", help="Port of this machine to be served on.", show_default="one that is free"
    ),
]
NoBrowser = Annotated[bool, typer.Option("--no-browser", help="Only print the address.")]
PAGES = (".html", ".htm")
EXTRA = (
    "it takes the extra live (starlette and uvicorn); pip install 'vfife[live]', or write a page that needs"
    " no server: -o PAGE.html"
)


def live(
    source: Source = None, out: Out = None, slide: Slide = None, no_sliders: NoSlide = False, port: Port = 0, no_browser: NoBrowser = False,
    set_: SetOption = None, laws: LawsOption = None,
) -> None:  # fmt: skip
    """See a mechanism run in a browser: served with Python behind it, or written as a page that needs no
    server.

    Without -o the page is served on this machine alone, until Ctrl-C: models are chosen from the gallery or
    the folder, edited, saved, run, and followed when their files change. With -o one file is written that
    runs in any browser. Both step with the bits of vfife run --companions 0. Sliders change every clearance,
    the speed of drivers, friction and restitution, unless --slide names others.
    """
    if out is None:
        serve(source, slide, no_sliders, port, not no_browser, set_, laws)
        return
    if source is None:
        fail(f"-o {out}: nothing says what runs in it; name a model or a run")
    write(source, out, slide, no_sliders, set_, laws)


def write(
    source: Path,
    out: Path,
    slide: list[str] | None,
    no_sliders: bool,
    set_: list[str] | None,
    laws: list[Path] | None,
) -> None:
    """Writes a page that needs no server."""
    if out.suffix.lower() not in PAGES:
        fail(f"-o {out}: a page is written, whose name ends in .html; name one")
    if not out.absolute().parent.is_dir():
        fail(f"-o {out}: there is no folder {out.absolute().parent}; make it first")
    with sentences(str(source)):
        from ...live.page.page import LARGEST

        take_laws(laws)
        text, notes, names = written(source, slide, no_sliders, set_)
        page = text.encode("utf-8")
        if len(page) > LARGEST:
            sizes = f"{amount_of_bytes(len(page))}, more than the {amount_of_bytes(LARGEST)} that a page may"
            raise ValueError(f"the page takes {sizes}; slide less, or use fewer elements")
    for note in notes:
        tell("note", f"{note}.")
    with writing(str(out)):
        kept(out, text)
    typer.echo(
        f"{out}: {amount_of_bytes(len(page))}, sliders: {', '.join(names) or 'none'}; open it in a browser."
    )


def written(
    source: Path, slide: list[str] | None, no_sliders: bool, set_: list[str] | None
) -> tuple[str, tuple[str, ...], list[str]]:
    """The page, sentences about it, and the names of its sliders; of a static analysis its equilibria, which
    have none.
    """
    from ...live import default_slides, model_of, parse_slides
    from ...live.page import page
    from ...live.page.patches import slider_patches

    mechanism, step = model_of(source, overrides(set_))
    if mechanism.settings.analysis == "static":
        from ...simulation.result import Result

        if slide:
            raise ValueError(
                "--slide: the equilibria of a static analysis are not found in the page, so nothing in it can"
                " be changed; leave it out"
            )
        ended = source.is_dir() or is_run_file(source)
        return (page.result_page(Result.load(source)) if ended else page.live_page(mechanism)), (), []
    found = slider_patches(
        mechanism,
        [] if no_sliders else parse_slides(mechanism, slide) if slide else default_slides(mechanism),
        step,
    )
    return page.written(found), found.notes, [one.name for one in found.slides]


def serve(
    source: Path | None,
    slide: list[str] | None,
    no_sliders: bool,
    port: int,
    browser: bool,
    set_: list[str] | None,
    laws: list[Path] | None,
) -> None:
    """Serves the page until Ctrl-C."""
    with sentences(str(source) if source else "vfife live"):
        try:
            from ...live.server.serving import served
        except ModuleNotFoundError as error:
            if error.name not in ("starlette", "uvicorn"):
                raise
            fail(f"vfife live: {EXTRA}")
        from ...live.server.session import Session

        take_laws(laws)
        settings = overrides(set_)
        a_run = source is not None and (source.is_dir() or is_run_file(source))
        folder = Path.cwd() if source is None or a_run else source.absolute().parent
        session = Session(
            folder, slide, not no_sliders, [f"--laws={Path(one).absolute()}" for one in laws or ()]
        )
        if source is None and (settings or slide):
            raise ValueError("--set and --slide are for a model that is named; name one, or leave them out")
        first = (
            None
            if source is None
            else (
                session.shelf.from_run(source, settings)
                if a_run
                else session.shelf.from_file(source, settings)
            )
        )
        session.pages.first = None if first is None else first.id
        try:
            with served(session, port) as serving:
                address = serving.address + (f"#{first.id}" if first else "")
                typer.echo(
                    f"{address}\nServed to browsers on this machine (port {serving.port}) that know this"
                    " address, until Ctrl-C."
                )
                NOW.saved = "What was saved is on disk."
                if browser:
                    show(address)
                serving.wait()
        except KeyboardInterrupt:
            if left := session.unsaved:
                NOW.saved = f"What was saved is on disk; changed and not saved: {', '.join(left)}."
            end_at_once()  # threads may be assembling or drawing, and need not be waited for


def show(address: str) -> None:
    """Opens a browser, where there is one; what it prints goes nowhere."""
    import webbrowser

    try:
        webbrowser.open(address)
    except (webbrowser.Error, OSError):
        tell("note", "no browser could be opened; open the address in one.")
