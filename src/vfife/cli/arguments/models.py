"""Arguments and options of commands about models, laws and vfife itself."""

from __future__ import annotations

from pathlib import Path

from ..options import (
    SET,
    JsonOptions,
    LawOptions,
    LengthOptions,
    ModelOptions,
    Options,
    argument,
    flag,
    option,
)


class CheckOptions(ModelOptions, LengthOptions, JsonOptions, function="check.check"):
    """Show what a run would compute: bodies, joints, masses, degrees of freedom, time step, and cost in
    steps, time and bytes.

    The command solves the ideal mechanism for the expected joint forces; it does not start the run.
    """

    long: bool = flag(
        "--long", "Also list all defaults, all limits of the step, and all rows of long tables."
    )


class NewOptions(Options, function="new.new"):
    """Write a commented model file to start from, to standard output or into a file."""

    name: str | None = argument("Name of the model; without it, list all models.", "[NAME]", None)
    out: Path | None = option(None, "File to write.", "FILE", "-o", "--out")
    force: bool = flag("--force", "Replace an existing file.")


class SchemaOptions(Options, function="new.schema"):
    """Print the JSON Schema of model files, study files or fit plans, for completion and checks in an editor:
    every key with its meaning, unit and limits.
    """

    out: Path | None = option(None, "File to write.", "FILE", "-o", "--out")
    study: bool = flag("--study", "Schema of study files instead.")
    fit: bool = flag("--fit", "Schema of fit plans instead.")


class LiveOptions(LawOptions, function="live.live"):
    """Show a running mechanism in a browser: served by Python for editing, or written as a page that needs no
    server.

    Without -o the page is served on this machine only, until Ctrl-C: choose models from the gallery or the
    folder, edit, save and run them; the page follows changes of their files. With -o the command writes one
    file that runs in any browser. Both give the same bits as vfife run --companions 0. Sliders change every
    clearance, driver speed, friction coefficient and restitution, unless --slide names others.
    """

    source: Path | None = argument(
        "Model file, or folder of a run, whose step the page uses; without it the page starts with the"
        " gallery.",
        "MODEL|RUN",
        None,
    )
    out: Path | None = option(None, "Write a page that needs no server.", "PAGE.html", "-o", "--output")
    slide: list[str] | None = option(
        None,
        "Parameter and range of a slider, as in joint.C.clearance=0.01..0.5mm; replaces the usual sliders;"
        " may be repeated.",
        "PATH=LOW..HIGH",
    )
    no_sliders: bool = flag("--no-sliders", "Write no sliders.")
    force: bool = flag("--force", "Replace an existing page.")
    port: int = option(0, "Port of the server on this machine.", "N", show_default="a free one")
    no_browser: bool = flag("--no-browser", "Print the address and open no browser.")
    set_: list[str] | None = option(None, SET, "PATH=VALUE", "--set")


class HelpOptions(JsonOptions, function="help.help_"):
    """Search commands, options, laws, measures, keys of a model file and documentation by a word."""

    words: list[str] | None = argument(
        "Words to search for; without them, list all commands by purpose.", "[WORD]...", None
    )


class LawsOptions(LawOptions, JsonOptions, function="laws.laws"):
    """List contact and friction laws, or show source, formula and parameters of one law, with units, defaults
    and limits.

    --plot draws one law: a contact law in free impacts (force over penetration, actual restitution), a
    friction law in steady sliding, and its presliding loops if it has memory.
    """

    name: str | None = argument("Name of a law; without it, list all laws.", "[NAME]", None)
    long: bool = flag("--long", "Show all details of each law instead of one line.")
    plot: bool = flag("--plot", "Draw the law: a free impact, or friction over sliding velocity.")
    picture: Path | None = option(
        None, "File of the drawing.", "FILE", "-o", "--output", show_default="NAME.png"
    )
    clearance: str = option("0.2 mm", "Clearance of the pair of surfaces.", "LENGTH")
    bearing_radius: str = option("10 mm", "Radius of the bearing.", "LENGTH")
    axial_length: str = option("20 mm", "Length of the pair of surfaces.", "LENGTH")
    material: str = option(
        "steel", 'Material of both surfaces, or "bearing,journal"; see `vfife materials`.', "NAME"
    )
    mass: str = option("1 kg", "Mass in a free impact.", "MASS")
    speed: str = option("1 m/s", "Speed of a free impact.", "SPEED")
    normal_force: str = option("100 N", "Normal force at which friction is shown.", "FORCE")
    set_: list[str] | None = option(
        None, "Set a parameter of the law, as in restitution=0.7.", "KEY=VALUE", "--set"
    )


class VerifyOptions(JsonOptions, function="verify.verify"):
    """Run the verification suite: compare results with published numbers, closed-form solutions and
    independent integrations. Exit code 1 if any case fails.

    `vfife verify measured` compares with measured pendulums and synthetic hysteresis loops instead, `vfife
    verify published` with published studies of linkages with clearance, `vfife verify trends` with
    statements of the literature on clearance and speed; each writes a page.
    """

    names: list[str] | None = argument(
        "Cases to run (default: all); or measured, published or trends, and items of that page.",
        "[CASE]...",
        None,
    )
    folder: Path | None = option(
        None, "Folder of the page; by default it has the name of the group.", "FOLDER", "-o", "--output"
    )
    listed: bool = flag("--list", "List the cases without running them.")


PAPER_ITEMS = (
    "fig8", "fig9", "fig10", "fig12", "fig13", "fig15", "fig16", "fig17", "table3", "fig18", "fig19", "fig20",
    "table4",
    "claims", "infer", "beyond",
)  # fmt: skip


class PaperOptions(JsonOptions, function="verify.paper"):
    """Recompute the figures and tables of the paper, judge its claims, and write a page.

    Without ITEM the command computes all items and uses the stored search for the lost parameters; `infer`
    searches again within its budget. The folder contains index.html, figures and paper.json. Ctrl-C keeps
    completed items.
    """

    item: str | None = argument(f"One of {', '.join(PAPER_ITEMS)}.", "[ITEM]", None, show_default="all")
    folder: Path = option(
        Path("paper"), "Folder of the page; it may exist already.", "FOLDER", "-o", "--output"
    )
    budget: float = option(600.0, "Time that `infer` may search.", "SECONDS", min=1.0)
    seed: int = option(1, "Seed of the search of `infer`.", "N", min=0)
    stored: bool = flag("--stored", "With `infer`: show the stored search instead of searching.")


class MaterialsOptions(JsonOptions, function="laws.materials"):
    """List materials that a model may name, with their properties and sources."""
