"""Arguments and options of commands about models, laws and vfife itself."""

from __future__ import annotations

from pathlib import Path

from ..options import OF_MODEL, SET, JsonOptions, LawOptions, ModelOptions, Options, argument, flag, option


class CheckOptions(ModelOptions, JsonOptions, function="check.check"):
    """Show what a run would compute: bodies, joints, masses, degrees of freedom, step, cost in steps, time
    and bytes.

    The run itself is not started. The ideal mechanism is solved, because the expected joint forces depend on
    it.
    """

    step: str | None = option(
        None,
        'Time step that the run would take, such as 1e-6 or "1 us", or auto.',
        "SECONDS",
        show_default=OF_MODEL,
    )
    turns: float | None = option(None, "Length in turns of the crank.", "N", show_default=OF_MODEL)
    long: bool = flag(
        "--long",
        "With all that was filled in by default, all limits of the step, and all rows of long tables.",
    )


class NewOptions(Options, function="new.new"):
    """Write a commented model file to start from, to standard output or into a file."""

    name: str | None = argument("Which one; without it all are listed.", "[NAME]", None)
    out: Path | None = option(None, "Write it into this file.", "FILE", "-o", "--out")
    force: bool = flag("--force", "Replace a file that is there.")


class SchemaOptions(Options, function="new.schema"):
    """JSON Schema of model files, study files or fit plans, for completion and checks in an editor: every key
    with its meaning, unit and limits.
    """

    out: Path | None = option(None, "Write it into this file.", "FILE", "-o", "--out")
    study: bool = flag("--study", "The schema of study files instead.")
    fit: bool = flag("--fit", "The schema of fit plans instead.")


class LiveOptions(LawOptions, function="live.live"):
    """See a mechanism run in a browser: served with Python behind it, or written as a page that needs no
    server.

    Without -o the page is served on this machine alone, until Ctrl-C: models are chosen from the gallery or
    the folder, edited, saved, run, and followed when their files change. With -o one file is written that
    runs in any browser. Both step with the bits of vfife run --companions 0. Sliders change every clearance,
    the speed of drivers, friction and restitution, unless --slide names others.
    """

    source: Path | None = argument(
        "Model file, or the folder of a run, whose step it takes; without one the page begins at the"
        " gallery.",
        "MODEL|RUN",
        None,
    )
    out: Path | None = option(None, "Write a page that needs no server.", "PAGE.html", "-o", "--output")
    slide: list[str] | None = option(
        None,
        "Make this number a slider, from and to, as in joint.C.clearance=0.01..0.5mm; then only"
        " these are sliders.",
        "PATH=LOW..HIGH",
    )
    no_sliders: bool = flag("--no-sliders", "Without any slider.")
    port: int = option(0, "Port of this machine to be served on.", "N", show_default="one that is free")
    no_browser: bool = flag("--no-browser", "Only print the address.")
    set_: list[str] | None = option(None, SET, "PATH=VALUE", "--set")


class HelpOptions(JsonOptions, function="help.help_"):
    """Search commands, options, laws, measures, keys of a model file and documentation by a word."""

    words: list[str] | None = argument("What to search for; without it, all purposes.", "[WORD]...", None)


class LawsOptions(LawOptions, JsonOptions, function="laws.laws"):
    """Contact and friction laws, a line each; of one that is named source, formula, parameters with units,
    defaults and limits.

    With --plot a law by itself: a contact law in free impacts (force over penetration, restitution
    delivered), a friction law in steady sliding, with the loops before it slides where it remembers.
    """

    name: str | None = argument("One law only.", "[NAME]", None)
    long: bool = flag("--long", "All that is known of each law, instead of a line.")
    plot: bool = flag("--plot", "Draw the law: a free impact, or friction over sliding velocity.")
    picture: Path | None = option(None, "Where to draw.", "FILE", "-o", "--output", show_default="NAME.png")
    clearance: str = option("0.2 mm", "Of the pair of surfaces.", "LENGTH")
    bearing_radius: str = option("10 mm", "Of the pair of surfaces.", "LENGTH")
    axial_length: str = option("20 mm", "Of the pair of surfaces.", "LENGTH")
    material: str = option("steel", 'Of both surfaces, or "bearing,journal"; see `vfife materials`.', "NAME")
    mass: str = option("1 kg", "Of a free impact.", "MASS")
    speed: str = option("1 m/s", "Of a free impact.", "SPEED")
    normal_force: str = option("100 N", "Under which friction is shown.", "FORCE")
    set_: list[str] | None = option(
        None, "Set a parameter of the law, as in restitution=0.7.", "KEY=VALUE", "--set"
    )


class VerifyOptions(JsonOptions, function="verify.verify"):
    """Run the verification suite: our numbers beside published ones, closed forms and independent
    integrations. Exit code 1 if any fails.

    `vfife verify measured` compares with measured pendulums and a hysteresis loop instead, `vfife verify
    published` with published studies of linkages with clearance, `vfife verify trends` with statements of the
    literature on clearance and speed; each writes a page.
    """

    names: list[str] | None = argument(
        "These cases only; measured, published or trends: write their page, with the items named after it.",
        "[CASE]...",
        None,
    )
    folder: Path | None = option(
        None, "Folder of the page, by default named as its group.", "FOLDER", "-o", "--output"
    )
    listed: bool = flag("--list", "List the cases and run none.")


PAPER_ITEMS = (
    "fig8", "fig9", "fig10", "fig12", "fig13", "fig15", "fig16", "fig17", "table3", "fig18", "fig19", "fig20",
    "table4",
    "claims", "infer", "beyond",
)  # fmt: skip


class PaperOptions(JsonOptions, function="verify.paper"):
    """Compute the paper's figures and tables anew, judge its claims, and write a page.

    Without ITEM all of them, with the stored search for the lost parameters; `infer` searches anew within its
    budget. The folder holds index.html, figures and paper.json. Ctrl-C keeps the items that are done.
    """

    item: str | None = argument(f"One of {', '.join(PAPER_ITEMS)}.", "[ITEM]", None, show_default="all")
    folder: Path = option(
        Path("paper"), "Folder of the page; it may be there already.", "FOLDER", "-o", "--output"
    )
    budget: float = option(600.0, "How long `infer` searches.", "SECONDS", min=1.0)
    seed: int = option(1, "Seed of the search of `infer`.", "N", min=0)
    stored: bool = flag("--stored", "With `infer`: show the stored search instead of searching.")


class MaterialsOptions(JsonOptions, function="laws.materials"):
    """Materials that a model may name, with their numbers and where these are from."""
