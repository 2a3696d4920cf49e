"""`vfife paper`: items by name, a page that stands alone, one JSON object, faults in a sentence."""

import base64
import dataclasses
import json
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path

import pytest

from vfife.cli.commands.verify import PAPER_ITEMS, paper_items
from vfife.report.document import Table
from vfife_validation.paper.answer import item_parts
from vfife_validation.paper.contents import Chart, Item, Line, Panel, Parameter, Verdict
from vfife_validation.paper.page import Folder, page


class Outline(HTMLParser):
    """Tags that are open, sections, images and all text of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.sections: list[str] = []
        self.images: list[dict[str, str]] = []
        self.links: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)
        if tag == "section":
            self.sections.append(found["id"])
        if tag == "img":
            self.images.append(found)
        if tag == "a":
            self.links.append(found["href"])

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def item(name: str = "one") -> Item:
    panel = Panel(
        "a < b",
        "x (m)",
        "y (N)",
        [Line([0.0, 1.0], [0.0, 2.0], "line"), Line([0.5], [1.0], "dot", "second", True)],
    )
    return Item(
        name, f"Title of {name}: more", ["5 < 6 & so on"], [Parameter("p", "1 mm", "inferred", "<lost>")],
        [Chart(name, "A chart", [panel], 1)],
        [Table(["a", "b"], [["true", "1 < 2"]], "cells")], [Verdict("claim", False, "1 & 2")], {"value": 1.5},
    )  # fmt: skip


def test_page_is_whole_and_stands_alone(tmp_path: Path) -> None:
    """Balanced tags, escaped text, pictures inside with words for those who do not see them, links that lead
    somewhere, nothing from elsewhere.
    """
    place = Folder(tmp_path / "page", "footer")
    for name in ("one", "two"):
        place.add(item(name), lambda value: json.dumps(value))
    text = place.index.read_text(encoding="utf-8")
    outline = Outline(text)
    assert (
        outline.open == [] and outline.sections == ["one", "two"] and set(outline.links) == {"#one", "#two"}
    )
    assert (
        "5 &lt; 6 &amp; so on" in text
        and "&lt;lost&gt;" in text
        and "http" not in text.replace("http-equiv", "")
    )
    for image in outline.images:
        assert image["alt"].endswith("A chart") and base64.b64decode(
            image["src"].partition(",")[2]
        ).startswith(b"\x89PNG")
    assert (tmp_path / "page" / "figures" / "two.png").read_bytes().startswith(b"\x89PNG")
    assert json.loads((tmp_path / "page" / "paper.json").read_text()) == {
        "one": {"value": 1.5},
        "two": {"value": 1.5},
    }


def test_an_item_without_parameters_has_no_table_of_them() -> None:
    def tables(one: Item) -> list[Table]:
        return [part for part in item_parts(one, alone=True) if isinstance(part, Table)]

    assert [len(one.rows) for one in tables(item())] == [1, 1]
    assert [one.title for one in tables(dataclasses.replace(item(), parameters=()))] == ["cells"]


def test_verdicts_and_origins_can_be_told_apart() -> None:
    text = page([item()], lambda chart: "x")
    assert all(f'<span class="{one}">{one}</span>' in text for one in ("false", "inferred", "true"))


def test_an_item_on_a_page_and_as_text(command: Callable) -> None:
    """A short item: claims in the terminal with their numbers, the page in the folder paper/, which may be
    there already.
    """
    for _ in range(2):
        done = command("paper", "fig10")
        assert done.exit_code == 0, done.stderr
        assert "true  The second peak is lower than the first" in done.stdout and "stated" in done.stdout
    assert Outline(Path("paper/index.html").read_text(encoding="utf-8")).sections == ["fig10"]


@pytest.mark.usefixtures("unrendered")
def test_json_of_table_3(command: Callable, tmp_path: Path) -> None:
    done = command("paper", "table3", "--json", "-o", tmp_path / "somewhere")
    assert done.exit_code == 0, done.stderr
    said = json.loads(done.stdout)
    assert [set(row) >= {"clearance_mm", "lip_force", "lip_acceleration"} for row in said["table3"]] == [
        True
    ] * 3
    assert 0.0 < said["parameters"]["axial_length"] < 0.1 and said["parameters"]["contact"] == "pereira"
    assert {entry["origin"] for entry in said["origins"]} == {"stated", "inferred", "chosen"}
    assert (tmp_path / "somewhere" / "index.html").is_file()


@pytest.mark.usefixtures("unrendered")
def test_stored_search_is_shown_without_searching(command: Callable) -> None:
    said = json.loads(command("paper", "infer", "--stored", "--json").stdout)
    assert said["provenance"]["command"].startswith("vfife paper infer") and len(said["structures"]) > 3


@pytest.mark.parametrize(("given", "meant"), [("fi16", "fig16"), ("tabel3", "table3"), ("beyound", "beyond")])
def test_an_item_there_is_not(command: Callable, given: str, meant: str) -> None:
    done = command("paper", given)
    assert done.exit_code == 2
    assert (
        f"the paper has no item '{given}'; did you mean '{meant}'?" in done.stderr
        and "Traceback" not in done.stderr
    )
    assert not Path("paper").exists()


@pytest.mark.parametrize(
    ("given", "meant"),
    [("Fig. 16", "fig16"), ("figure 8", "fig8"), ("Table 3", "table3"), ("CLAIMS", "claims")],
)
def test_items_as_people_write_them(given: str, meant: str) -> None:
    assert paper_items(given) == [meant] and paper_items(None) == list(PAPER_ITEMS)


def test_a_file_in_the_way(command: Callable, tmp_path: Path) -> None:
    (tmp_path / "here").write_text("mine")
    done = command("paper", "fig10", "-o", "here")
    assert done.exit_code == 2 and "-o here: this is a file; name a folder" in done.stderr
    assert (tmp_path / "here").read_text() == "mine"


@pytest.mark.usefixtures("unrendered")
def test_ctrl_c_keeps_what_is_done(command: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    """The third item is interrupted: two are on the page, the exit code tells."""
    from vfife_validation.paper import items

    def make(name, context):
        if name == "fig10":
            raise KeyboardInterrupt
        return item(name)

    monkeypatch.setattr(items, "make", make)
    done = command("paper")
    assert done.exit_code == 130 and "2 of 16 items were done; they are kept in paper" in done.stderr
    assert Outline(Path("paper/index.html").read_text(encoding="utf-8")).sections == ["fig8", "fig9"]
