"""The report of a run: what it says is what was found, names are text, and nothing is fetched."""

import copy
import re
import string
import zlib
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image
from typer.testing import CliRunner

import vfife
from vfife import gallery
from vfife.cli.app import app
from vfife.errors import VfifeError
from vfife.live.page import reports
from vfife.modelfile import dump, load
from vfife.plots.notebook import reported_figures
from vfife.plots.pdf import figure_scale, fullest
from vfife.report import front, overview, pages, run_file
from vfife.report.amounts import interval, prefixed
from vfife.report.damping_cautions import comparison
from vfife.report.digits import measure_text
from vfife.report.front import TERMS, conclusion, explained, without_options
from vfife.report.html import elements
from vfife.report.overview import cautions, certainty, joint_table
from vfife.report.pages import findings, model_file, trust
from vfife.report.pages import run_page as document
from vfife.report.parts import NO_BREAK, Paragraph, Section, Table
from vfife.report.run import equilibria
from vfife.report.run_tables import tables
from vfife.simulation.result import Result

NAME = "<script>alert(1)</script> & <b>bold</b> </iframe>"


class Page(HTMLParser):
    """What a browser makes of it: elements, their attributes, texts by element."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: dict[str, list[str]] = {}
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.open.append(tag)
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        while self.open and self.open.pop() != tag:
            pass

    def handle_data(self, data: str) -> None:
        """Keep a text, its spaces at which no line ends as other ones."""
        self.texts.setdefault(self.open[-1] if self.open else "", []).append(data.replace(NO_BREAK, " "))


@cache
def run() -> Result:
    mechanism = gallery.four_bar_case_c()
    mechanism.name = NAME
    return vfife.simulate(mechanism, turns=0.25, outputs=90, companions=0, loop="data-driven")


@cache
def page() -> Page:
    return Page(document(run(), {NAME: "<img alt='' src='data:,'>"}, f"<p>{NAME}</p>", None))


def words(of: Page) -> str:
    return " ".join(" ".join(one) for one in of.texts.values())


def test_names_with_markup_are_text() -> None:
    assert (
        page().texts["h1"] == [NAME]
        and page().texts["figcaption"] == [NAME]
        and page().texts["title"] == [f"{NAME}: report"]
    )
    assert {"script", "b"}.isdisjoint(tag for tag, _ in page().elements)


def test_the_page_in_the_page_is_whole_and_kept_apart() -> None:
    (frame,) = (attributes for tag, attributes in page().elements if tag == "iframe")
    assert frame["srcdoc"] == f"<p>{NAME}</p>" and "allow-same-origin" not in frame["sandbox"]


def test_nothing_is_fetched() -> None:
    for _, attributes in page().elements:
        assert all(
            (attributes.get(key) or "data:").startswith(("data:", "#")) for key in ("src", "href", "action")
        )
    assert not re.search(r"@import|url\(", "".join(page().texts["style"]))


def test_peaks_ledger_and_onsets_are_those_of_the_channels() -> None:
    """The largest of the recorded extremes, the open part of the ledger, the deepest first contact."""
    result, said = run(), words(page())
    forces = result.channels["joint_force_max"].values[1:].max(axis=0)
    cells = Page(elements(findings(result.summary))).texts["td"]
    for name, force in zip(result.data.joint.values, forces, strict=True):
        told = float(
            cells[cells.index(str(name)) + 1].removesuffix(" kN").removesuffix(" N").replace(",", "")
        )
        assert told == pytest.approx(force, rel=1e-4) or told == pytest.approx(1e-3 * force, rel=1e-4)
    assert f"ledger closes to {result.ledger.error:.1e}" in said and "Depth at which contacts began" in said
    assert (
        np.isfinite(result.measures["B.landing_depth.max"])
        and prefixed(result.measures["B.landing_depth.max"], "m") in said
    )


def test_every_caution_of_the_summary_is_in_it() -> None:
    items = page().texts["li"]
    summary = run().summary
    told = [*cautions(summary), *summary["warnings"], *summary["remarks"]]
    assert items == list(dict.fromkeys(map(without_options, told))) and len(items) > len(summary["warnings"])


@pytest.mark.parametrize("certain", ["the same sentence", "another sentence"])
def test_a_verdict_stands_once(monkeypatch: pytest.MonkeyPatch, certain: str) -> None:
    """In the conclusion, or where that has other words in the section on trust; never also as a caution."""
    told = run().summary | {"warnings": ["the same sentence", "a caution"]}
    monkeypatch.setattr(pages, "run_summary", lambda result: told)
    for module in (pages, overview):
        monkeypatch.setattr(module, "verdict", lambda summary: "the same sentence")
    for module in (pages, front):
        monkeypatch.setattr(module, "certainty", lambda summary: certain)
    said = Page(document(run(), {}, None, None))
    assert words(said).count("the same sentence") == 1 and words(said).count("a caution") == 1
    assert "the same sentence" not in said.texts["li"] and certain in said.texts["p"]


FRAME = Path(vfife.__file__).parent / "modelfile" / "templates" / "frame.toml"


def test_a_verdict_without_cautions_is_not_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """A report that begins with "this run is sensitive" and says "Cautions: None." contradicts itself."""
    result = vfife.simulate(load(FRAME), duration=0.05)
    assert "None." in Page(document(result, {}, None, None)).texts["p"]
    sensitive = copy.deepcopy(result.summary)
    sensitive["trust"]["converges"], sensitive["trust"]["sensitive"] = False, True
    monkeypatch.setattr(pages, "run_summary", lambda result: sensitive)
    texts = Page(document(result, {}, None, None)).texts["p"]
    assert pages.NO_OTHER in texts and "None." not in texts and "does not converge" in " ".join(texts)


def test_a_report_speaks_of_turns_and_ideal_joints_only_where_there_are_some() -> None:
    """A frame has neither, nor a figure of the angular accelerations that rounding leaves."""
    frame = vfife.simulate(load(FRAME), duration=0.05)
    titles = " ".join(reported_figures(frame))
    assert "joint forces over time, with the peaks" in titles.lower() and "faint later" in titles
    assert "turn" not in titles and "ideal" not in titles and "acceleration" not in titles.lower()
    texts = " ".join(Page(document(frame, {}, None, None)).texts["p"])
    assert "central differences." in texts and "clearance" not in texts.partition("central")[2][:200]
    assert "Joint forces over the turn, with the ideal ones" in " ".join(reported_figures(run()))
    pendulum = vfife.simulate(gallery.elastic_pendulum(), duration=0.05)
    assert "Angular accelerations of bodies that are not driven" in reported_figures(pendulum)


def test_joints_with_equal_laws_share_a_row() -> None:
    cells = page().texts["td"]
    assert cells.count("lankarani-nikravesh") == 2, "once with its parameters, once with its source"
    assert "B, C, D" in cells
    summary = run().summary
    contents = {"laws": {f"{joint}.hertz": "a book" for joint in "BCD"}, "summary": summary}
    (law,) = (text for name, text in run_file._law_facts(contents) if name == "Law")
    assert law == "B, C, D.hertz: a book"


def test_the_conclusion_rounds_as_the_table_does() -> None:
    """The sentences on cost, joint and trust have the range of the table."""
    summary = copy.deepcopy(run().summary)
    summary.pop("start_fall", None)
    largest = max(summary["joints"], key=lambda name: summary["joints"][name]["force.max"])
    measure = f"{largest}.force.max"
    summary["measures"][measure] = 10.4e6
    summary["joints"][largest]["force.max"] = 10.4e6
    bounds = {"low": 9.43e6, "high": 11.48e6, "lowest": 10.4e6, "highest": 10.4e6, "estimated": True}
    summary["ranges"] = {
        name: {"low": value, "high": value, "lowest": value, "highest": value, "estimated": True}
        for name, value in summary["measures"].items()
    } | {measure: bounds}
    summary["not_estimated"] = []
    summary["trust"] = {"sensitive": True, "converges": True, "lost": 0, "measure": measure}
    summary["lip"] = {f"{largest}.force": 900.0}
    summary |= {"law_dependent": {}, "law_shocks": {}, "law_loads": {}}
    texts = [*conclusion(summary), *(cell for row in joint_table(summary).rows for cell in row)]
    assert [text for text in texts if "9.4 to 11.5 MN" in text] == [*texts[:2], texts[3], "9.4 to 11.5 MN"], (
        texts
    )


def test_a_fact_stands_where_it_belongs() -> None:
    """Laws take several lines, of which the first alone has a name; they are derived parameters, and no
    matter of trust.
    """
    told = run().summary | {"remarks": ["a remark on a law"]}
    assert not any(
        "a remark on a law" in one or "lankarani" in one
        for one in (elements(findings(told)), elements(trust(told)))
    )
    assert "law" in page().texts["th"] and any("Lankarani" in cell for cell in page().texts["td"])


def test_inputs_are_shown_as_given_with_whether_they_give_the_run(tmp_path: Path) -> None:
    path = tmp_path / "given.toml"
    path.write_text((Path(__file__).parents[2] / "examples" / "four_bar_case_c.toml").read_text("utf-8"))
    kept = dump(load(path))
    (part,) = model_file(kept, str(path))
    assert "The run has these numbers." in elements([part]) and part.text == path.read_text("utf-8")
    result = vfife.simulate(load(path), turns=0.01, companions=0, reference=False, loop="data-driven")
    result.report(tmp_path / "report.html", running=False)
    said = (tmp_path / "report.html").read_text("utf-8")
    assert (
        "Read from given.toml." in said
        and "given.toml. The run has these numbers." in said
        and str(tmp_path) not in said
        and "<iframe" not in said
    )
    _, changed = model_file(kept.replace("0.15", "0.16"), str(path))
    assert "0.16" in changed.text and len(changed.text.splitlines()) < 4
    wide = load(path, {"joint.C.clearance": "75 um", "driver.crank.speed": "300 rpm", "run.turns": 20})
    _, changed = model_file(dump(wide), str(path))
    assert changed.text.splitlines() == [
        "run.turns = 20.0", "joint.C.clearance = 7.5e-05  (75 µm)", "driver.crank.speed = 31.4159  (300 rpm)",
    ]  # fmt: skip
    assert (
        "is missing or cannot be read" in elements(model_file(kept, str(tmp_path / "gone.toml")))
        and model_file(kept, None) == []
    )


def test_equilibria_have_a_report() -> None:
    result = vfife.simulate(gallery.toggle_press())
    said = Page(document(result, {}, None, None))
    assert "load factor" in " ".join(said.texts["th"]) and "Trust" not in said.texts["h2"]


def test_a_page_does_not_part_a_number_from_its_unit() -> None:
    """Neither in sentences nor in cells; an ordinary word behind a number is no unit."""
    text = elements([Paragraph("0.9 to 1.2 kN in 3 turns"), Table(("a",), [("big-end 17 µm",)])])
    assert f"0.9 to 1.2{NO_BREAK}kN in 3 turns" in text and f"17{NO_BREAK}µm" in text
    assert f"2.7{NO_BREAK}N{NO_BREAK}m" in elements([Paragraph("torque 2.7 N m")])


def test_load_factors_that_a_table_leaves_out_are_named() -> None:
    """The short answer has three of five; the long one has all, or says how many it has not."""

    def table(summary: dict[str, Any], limit: int = 40) -> Table:
        return next(part for part in equilibria(summary, limit) if isinstance(part, Table))

    summary = vfife.simulate(gallery.toggle_press()).summary
    short, whole = table(summary, 3), table(summary)
    assert [row[0] for row in short.rows] == ["0", "0.5", "1"]
    assert short.note == "Left out: load factors 0.25 and 0.75; add --long, or vfife info RUN --long."
    assert [row[0] for row in whole.rows] == ["0", "0.25", "0.5", "0.75", "1"] and not whole.note
    factors = summary["run"]["factors"]
    many = [state | {"load_factor": 5.0 * k + j} for k in range(20) for j, state in enumerate(factors)]
    table_of_many = table(summary | {"run": summary["run"] | {"factors": many}})
    left = len(many) - len(table_of_many.rows)
    assert left > 0
    assert table_of_many.note == f"Left out: {left} load factors between these; the run file has all."


@pytest.mark.system("draws a report")
def test_the_command_writes_one_file_and_replaces_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run().save(tmp_path / "run.sqlite")
    line = ["report", str(tmp_path), "-o", str(tmp_path / "r.html")]
    monkeypatch.setattr(reports, "result_page", lambda result: "x" * 4_000_000)
    said = CliRunner().invoke(app, line)
    assert (
        said.exit_code == 0 and "left out" in said.stderr and (tmp_path / "r.html").stat().st_size < 4_000_000
    )
    titles = Page((tmp_path / "r.html").read_text("utf-8")).texts["h2"]
    assert titles == [
        "Conclusion", "Cautions", "Method and trust", "Results in numbers", "Figures", "Derived parameters",
        "Appendix: the model",
    ]  # fmt: skip
    again = CliRunner().invoke(app, line)
    assert again.exit_code == 2 and "--force" in again.stderr


def test_the_conclusion_is_made_of_the_numbers() -> None:
    """Cost, joint and certainty: each number in them is that of the summary; without clearance there is no
    cost.
    """
    certain, cost, joint, knocks = conclusion(run().summary)
    assert certain == certainty(run().summary) and certain.startswith("The largest forces are those of the")
    summary = {key: value for key, value in run().summary.items() if key != "start_fall"}
    assert conclusion(summary)[:3] == [cost, joint, knocks]
    certain = conclusion(summary)[3]
    largest = max(summary["joints"], key=lambda name: summary["joints"][name]["force.max"])
    worst = max("BCD", key=lambda name: summary["lip"][f"{name}.force"])
    assert (
        f"in joint {largest}" in cost and prefixed(summary["joints"][largest]["ideal_force.max"], "N") in cost
    )
    assert f", {worst} (" in joint and measure_text(summary, f"{worst}.force.max", "N") in joint
    assert certain == certainty(summary)
    speeds = {name: summary["knocks"][name]["speed"] for name in "BCD"}
    hardest = max(speeds, key=speeds.__getitem__)
    assert knocks.startswith(f"Joint {hardest} knocks hardest: its surfaces meet at up to ")
    milder = sorted(set("BCD") - {hardest}, key=lambda name: -speeds[name])
    assert re.findall(r"[;,] ([BCD]) \d", knocks) == milder
    quiet = copy.deepcopy(summary)
    quiet["knocks"] = {name: {"count": 0, "speed": 0.0, "hardest": False} for name in "BCD"}
    assert conclusion(quiet)[2].startswith("No joint knocks in these turns; in the whole run, B ")
    doubled = copy.deepcopy(summary)
    doubled["lip"]["B.force"] = 900.0
    assert ", B (" in conclusion(doubled)[1]
    ideal = vfife.simulate(gallery.four_bar_ideal(), turns=0.1, companions=0, loop="data-driven")
    assert conclusion(ideal.summary)[0].startswith("No joint has clearance; the largest joint force is ")


def with_ranges(**ends: tuple[float, float]) -> dict[str, Any]:
    """The summary with these ranges of forces (N)."""
    changed = copy.deepcopy(run().summary)
    changed.pop("start_fall", None)
    known = [f"{name}.force.max" for name in ends]
    changed["not_estimated"] = [name for name in changed["measures"] if name not in known]
    for name, (low, high) in ends.items():
        changed["ranges"][f"{name}.force.max"] = {"low": low, "high": high, "lowest": low, "highest": high}
    return changed


def test_the_largest_force_is_that_of_all_joints_that_may_have_it() -> None:
    """A joint with a smaller value and a range that reaches further is named beside the largest."""
    sizes = {name: run().summary["measures"][f"{name}.force.max"] for name in "ABCD"}
    first, second, _, last = sorted("ABCD", key=lambda name: -sizes[name])
    exact = {name: (size, size) for name, size in sizes.items()}
    high = 2.0 * sizes[first]
    wide = with_ranges(**exact | {first: (0.5 * sizes[first], 1.1 * sizes[first]), last: (0.0, high)})
    cost = conclusion(wide)[0]
    joints = re.search(r", in joint (.+?); with", cost)
    assert joints is not None and {first, last} <= {*re.split(", | or ", joints[1])}
    assert interval(max(sizes[second], 0.5 * sizes[first]), high, "N", high) in cost
    alone = with_ranges(**{name: (0.999 * size, 1.001 * size) for name, size in sizes.items()})
    assert f" in joint {first};" in conclusion(alone)[0]


def test_a_report_names_no_options() -> None:
    sizes = run().summary["measures"]
    names = [name.removesuffix(".force.max") for name in sizes if name.endswith(".force.max")]
    summary = with_ranges(
        **{name: (0.5 * sizes[f"{name}.force.max"], 1.5 * sizes[f"{name}.force.max"]) for name in names}
    )
    summary["turns"], summary["run"] = None, summary["run"] | {"steady": True, "turns": 1.0}
    summary["trust"] = {"sensitive": False, "converges": True, "measure": "B.force.max", "automatic": True}
    assert "(--long)" in certainty(summary) and "--settle" in " ".join(cautions(summary))
    text = " ".join([*conclusion(summary), *map(without_options, cautions(summary))])
    assert not re.search(r"--[a-z]", text) and "until they repeat within 1 %" in text


def test_a_report_names_laws_to_compare_instead_of_a_command() -> None:
    machine = vfife.gallery.compressor()
    pins, all_joints = ["big-end", "small-end"], list(machine.contacts)
    told = [f"Shocks: {comparison(machine, names)}." for names in (pins, all_joints)]
    assert all("--" in text for text in told)
    assert [without_options(text) for text in told] == [
        "Shocks: compare the contact laws lankarani-nikravesh, hertz and gonthier.",
        "Shocks: compare contact.law=hertz in these joints.",
    ]


def test_an_ideal_force_of_rounding_is_about_zero() -> None:
    summary = copy.deepcopy(run().summary)
    summary["joints"]["B"]["ideal_force.max"] = 1.949e-17
    (row,) = (row for row in joint_table(summary).rows if row[0].split()[0] == "B")
    assert row[1] == "about 0"
    (row,) = (row for table in tables(summary) for row in table.rows if row[0] == "B" and "about 0" in row)
    assert "1.949e-17" not in " ".join(row)


def test_terms_are_explained_where_they_occur_first() -> None:
    sections = explained(
        [Section("One", [Table(("change",), [("1",)])]), Section("Two", [Table(("change",), [])])]
    )
    assert [type(part).__name__ for one in sections for part in one.parts] == ["Table", "Facts", "Table"]
    assert sections[0].parts[1].rows == [("change", TERMS["change"])]


@pytest.mark.system("draws a report")
def test_a_pdf_is_one_with_its_text(tmp_path: Path) -> None:
    """Readable pages with title, author, conclusion and the model as it was written."""
    logo = tmp_path / "logo.png"
    Image.new("RGB", (30, 10)).save(logo)
    path = tmp_path / "model.toml"
    path.write_text((Path(__file__).parents[2] / "examples" / "four_bar_case_c.toml").read_text("utf-8"))
    result = vfife.simulate(load(path), turns=0.1, companions=0)
    assert result.report(tmp_path / "r.pdf", author="A. Engineer", logo=logo) == ()
    data = (tmp_path / "r.pdf").read_bytes()
    streams = [
        # Without its last byte where that is \r, which belongs to the checksum and not to the line end.
        zlib.decompressobj().decompress(one)
        for one in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", data, re.S)
        if one[:1] == b"x"
    ]
    # By a table, because streams hold images of many megabytes.
    text = b"".join(streams).translate(None, bytes(set(range(256)) - set(string.ascii_letters.encode())))
    assert (
        data.startswith(b"%PDF") and len(re.findall(rb"/Type /Page\b", data)) >= 4 and b"A. Engineer" in data
    )
    for word in (
        b"Conclusion",
        b"Withclearancethelargestjointforce",
        b"Cautions",
        b"Aswritten",
        b"Resultsinnumbers",
    ):
        assert word in text, word
    with pytest.raises(VfifeError, match="written as .html or .pdf"):
        reports.report(result, tmp_path / "r.docx")
    with pytest.raises(VfifeError, match="neither a PNG nor a JPEG"):
        reports.report(result, tmp_path / "r.html", logo=path)
    assert sorted(one.name for one in tmp_path.iterdir()) == ["logo.png", "model.toml", "r.pdf"]


def test_a_first_page_that_overflows_is_followed_directly(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One sentence on the second page leaves room for the next section; without it a new page begins."""
    from vfife.plots import pdf
    from vfife.report.document import Document, Paragraph

    for count in (1, 26):
        first = Section("Conclusion", [Paragraph(f"Sentence {k}.") for k in range(count)])
        document = Document([first, Section("Cautions", [Paragraph("Care.")])], "title")
        pages: list[list[str]] = []
        with monkeypatch.context() as patch:

            def end(paper: pdf.Paper, pages: list[list[str]] = pages) -> None:
                pages.append([text.get_text() for text in paper.page.texts])

            patch.setattr(pdf.Paper, "end", end)
            pdf.write_pdf(tmp_path / "r.pdf", document, [], {})
        assert len(pages) == 2 and "Cautions" in pages[1], pages
        assert ("Sentence 25." in pages[1]) == (count == 26)


def test_the_figure_of_the_first_page_leaves_room_for_its_sentences() -> None:
    """It shrinks where all of the section then fits, and keeps its height where it does not."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    from vfife.plots import pdf
    from vfife.report.document import Paragraph
    from vfife.report.parts import Figure as Drawn

    figure = Figure(figsize=(6.0, 4.2))
    FigureCanvasAgg(figure)
    heights = []
    for count in (1, 14, 40):
        texts = [Paragraph(f"Sentence {k}.") for k in range(count)]
        section = Section("Conclusion", [Drawn("drawing", lambda: ""), *texts])
        paper = pdf.Paper(None, "title")
        paper.tallest = pdf.tallest_first(paper, section, {"drawing": figure})
        heights.append(paper.tallest)
        pdf._section(paper, section, {"drawing": figure}, True)
        assert (paper.count == 1) == (count < 40), (count, paper.at)
    assert heights[0] == heights[2] == pdf.TALL_FIRST and pdf.SHORT_FIRST < heights[1] < pdf.TALL_FIRST


def test_figures_fill_pages_and_have_one_scale() -> None:
    heights = {"first": 3.0, "tall": 7.5, "second": 2.5, "third": 4.0}
    assert fullest(heights, 10.0) == ["first", "second", "third"]
    assert fullest(heights, 11.0) == ["first", "tall"]
    assert fullest(heights, 2.0) == ["first"], "what fits nowhere else stands on a page of its own"
    assert figure_scale(Figure(figsize=(4.0, 3.0))) == figure_scale(Figure(figsize=(9.0, 3.0)))


def test_the_appendix_holds_the_tables_that_a_model_reads(tmp_path: Path) -> None:
    path = tmp_path / "model.toml"
    table = "time (s), factor\n0, 0\n1, 17.25\n"
    (tmp_path / "push.csv").write_text(table)
    load_text = '[load.push]\nat = "coupler.end"\nforce = ["1 N", 0]\ntable = "push.csv"\n'
    example = Path(__file__).parents[2] / "examples" / "four_bar_case_b.toml"
    path.write_text(example.read_text("utf-8") + load_text)
    appendix = model_file(dump(load(path)), str(path))
    assert [(part.title, part.text) for part in appendix[1:]] == [("Table push.csv", table)]


def test_a_report_has_no_folder_of_the_user(tmp_path: Path) -> None:
    """The line for editors that vfife new writes names the schema by its place on the disk."""
    text = vfife.gallery.path("four_bar").read_text(encoding="utf-8")
    file = tmp_path / "model.toml"
    file.write_text(f"#:schema file:///home/me/model.schema.json\n{text}", encoding="utf-8")
    written = str(model_file("", str(file)))
    assert text.splitlines()[0] in written and "#:schema" not in written and "/home/me" not in written


def test_the_first_sentence_of_a_report_tells_that_a_force_is_a_mean_over_turns() -> None:
    summary = with_ranges(B=(300.0, 400.0), C=(1000.0, 1400.0), D=(300.0, 400.0))
    assert "mean" not in conclusion(summary)[0]
    summary["turns"] = {
        **(summary["turns"] or {}),
        "motion": "not repeating",
        "count": 20,
        "first": 11,
        "last": 20,
    }
    for joint, highest in (("B", 500e3), ("D", 400e3)):
        value = summary["measures"][f"{joint}.force.max"]
        summary["ranges"][f"{joint}.force.max"] |= {"lowest": 0.5 * value, "highest": highest}
    first, joint, *_ = conclusion(summary)
    assert first.startswith("With clearance the largest joint force, a mean over turns, is "), first
    assert re.search(r"; single turns reach 500(\.\d+)? kN, in joint B; with ideal joints it is", first), (
        first
    )
    assert " (mean), a change of " in joint


def test_single_turns_are_those_of_the_joint_whose_turns_reach_most() -> None:
    """The turns of the most loaded joint agree within its range; a smaller force whose turns differ says
    nothing about the largest one.
    """
    summary = with_ranges(B=(300.0, 400.0), C=(1000.0, 1400.0), D=(300.0, 400.0))
    summary["turns"] = {
        **(summary["turns"] or {}),
        "motion": "not repeating",
        "count": 20,
        "first": 11,
        "last": 20,
    }
    summary["ranges"]["D.force.max"] |= {"lowest": 100.0, "highest": 900.0}
    first, *_ = conclusion(summary)
    assert first.startswith("With clearance the largest joint force, a mean over turns, is "), first
    assert "single turns" not in first
    summary["ranges"]["D.force.max"]["highest"] = 1700.0
    assert "; single turns reach 1.7 kN, in joint D" in conclusion(summary)[0]
