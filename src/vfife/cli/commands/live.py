"""``vfife live``: a page in which a mechanism runs, as a file or served with Python behind it."""

from __future__ import annotations

import webbrowser
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import typer

from ...files import write_text
from ...files.kinds import refuse_kind
from ...job.activity import ACTIVITY
from ...live import default_slides, model_of, parse_slides
from ...live.page import page
from ...live.page.page import LARGEST
from ...live.page.patches import slider_patches
from ...simulation.result import Result
from ...store.schemas import is_run_file
from ..arguments.models import LiveOptions
from ..outputs import refuse_existing
from ..signals import ENDING, end_at_once
from ..terminal import amount_of_bytes, fail, sentences, tell, writing
from ..values import overrides, take_laws

PAGES = (".html", ".htm")
EXTRA = (
    "it takes the extra live (starlette and uvicorn); pip install 'vfife[live]', or write a page that needs"
    " no server: -o PAGE.html"
)


def live(options: LiveOptions) -> None:
    """Run ``vfife live``."""
    if options.out is None:
        serve(options)
    elif options.source is None:
        fail(f"-o {options.out}: the page needs a mechanism; name a model or a run")
    else:
        write(options, options.source, options.out)


def write(options: LiveOptions, source: Path, out: Path) -> None:
    """Write a page that needs no server."""
    if out.suffix.lower() not in PAGES:
        fail(f"-o {out}: the name of a page ends in .html")
    with sentences(str(out)):
        refuse_existing(out, options.force)
    with sentences(str(source)):
        take_laws(options.laws)
        ACTIVITY(f"assembling the page of {source} and its sliders")
        page = make_page(options, source)
        size = len(page.text.encode("utf-8"))
        if size > LARGEST:
            sizes = f"{amount_of_bytes(size)}, more than the {amount_of_bytes(LARGEST)} that a page may"
            raise ValueError(f"the page takes {sizes}; slide less, or use fewer elements")
    for note in page.notes:
        tell("note", f"{note}.")
    with writing(str(out)):
        write_text(out, page.text)
    typer.echo(
        f"{out}: {amount_of_bytes(size)}, sliders: {', '.join(page.sliders) or 'none'}; open it in a browser."
    )


class Page(NamedTuple):
    """The text of a page, sentences about it, and the names of its sliders."""

    text: str
    notes: tuple[str, ...] = ()
    sliders: Sequence[str] = ()


def make_page(options: LiveOptions, source: Path) -> Page:
    """Build the page of a model; a static analysis shows its equilibria and has no sliders."""
    mechanism, step = model_of(source, overrides(options.set_))
    if mechanism.settings.analysis == "static":
        if options.slide:
            raise ValueError(
                "--slide: the equilibria of a static analysis are not found in the page, so nothing in it can"
                " be changed; leave it out"
            )
        is_run = source.is_dir() or is_run_file(source)
        return Page(page.result_page(Result.load(source)) if is_run else page.live_page(mechanism))
    slides = parse_slides(mechanism, options.slide) if options.slide else default_slides(mechanism)
    model = slider_patches(mechanism, [] if options.no_sliders else slides, step)
    return Page(page.page_with_sliders(model), model.notes, [slider.name for slider in model.slides])


def serve(options: LiveOptions) -> None:
    """Serve the page until Ctrl-C."""
    source, laws, slide = options.source, options.laws, options.slide
    with sentences(str(source) if source else "vfife live"):
        try:
            from ...live.server.app import served
        except ModuleNotFoundError as error:
            if error.name not in ("starlette", "uvicorn"):
                raise
            fail(f"vfife live: {EXTRA}")
        from ...live.server.session import Session

        take_laws(laws)
        settings = overrides(options.set_)
        a_run = source is not None and (source.is_dir() or is_run_file(source))
        if source is not None and not a_run:
            refuse_kind(source, "model")
        folder = Path.cwd() if source is None or a_run else source.absolute().parent
        session = Session(
            folder, slide, not options.no_sliders, [f"--laws={Path(file).absolute()}" for file in laws or ()]
        )
        if source is None and (settings or slide):
            raise ValueError("--set and --slide need a model; name one, or leave them out")
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
            with served(session, options.port) as serving:
                address = serving.address + (f"#{first.id}" if first else "")
                typer.echo(
                    f"{address}\nServed to browsers on this machine (port {serving.port}) that know this"
                    " address, until Ctrl-C."
                )
                ENDING.saved = "Saved files are on disk."
                ACTIVITY.end()  # the server waits for its readers
                if not options.no_browser:
                    show(address)
                serving.wait()
        except KeyboardInterrupt:
            if left := session.unsaved:
                ENDING.saved = f"Saved files are on disk; changed and not saved: {', '.join(left)}."
            end_at_once()  # threads may be assembling or drawing, and need not be waited for


def show(address: str) -> None:
    """Open a browser, where one is installed, and discard its messages."""
    try:
        webbrowser.open(address)
    except (webbrowser.Error, OSError):
        tell("note", "no browser could be opened; open the address in one.")
