"""``vfife live``: a page from a model or a run, sliders by their paths, sentences for what cannot be."""

from typer.testing import CliRunner

from live.pages import scripts_of
from vfife import gallery, simulate
from vfife.cli.app import app
from vfife.modelfile import dump


def told(*arguments: str):
    return CliRunner().invoke(app, ["live", *map(str, arguments)])


def test_a_model_becomes_a_page(tmp_path):
    model, page = tmp_path / "crank.toml", tmp_path / "page.html"
    model.write_text(dump(gallery.four_bar_case_b()), "utf-8")
    done = told(
        model, "-o", page, "--slide", "joint.C.clearance=0.15..0.25mm", "--set", "joint.C.clearance=0.2 mm"
    )
    assert done.exit_code == 0, done.output
    assert "joint.C.clearance" in done.output
    given = scripts_of(page.read_text("utf-8"))
    assert [slide["name"] for slide in given["slides"]] == ["joint.C.clearance"]
    page.write_text("mine", "utf-8")
    done = told(model, "-o", page, "--no-sliders")
    assert done.exit_code == 2 and "add --force to replace it" in " ".join(done.stderr.split())
    assert page.read_text("utf-8") == "mine"
    done = told(model, "-o", page, "--no-sliders", "--force")
    assert done.exit_code == 0 and page.read_text("utf-8") != "mine", done.output


def test_a_run_becomes_a_page_with_its_step(tmp_path):
    result = simulate(
        gallery.four_bar_case_b(), turns=0.05, step=2e-6, companions=0, reference=False, loop="data-driven"
    )
    result.save(tmp_path / "run.sqlite")
    done = told(tmp_path / "run.sqlite", "-o", tmp_path / "page.html", "--no-sliders")
    assert done.exit_code == 0, done.output
    given = scripts_of((tmp_path / "page.html").read_text("utf-8"))
    assert given["step"] == result.record.assembly.choice.step and given["slides"] == []


def test_what_cannot_be_a_page_is_told_in_a_sentence(tmp_path):
    static = tmp_path / "press.toml"
    static.write_text(dump(gallery.toggle_press()), "utf-8")
    moving = tmp_path / "bar.toml"
    moving.write_text(dump(gallery.four_bar_case_b()), "utf-8")
    for arguments, said in (
        ((static, "--slide", "run.tolerance=1e-6..1e-3"), "leave it out"),
        ((tmp_path / "none.toml",), "cannot be read"),
        ((tmp_path,), "is a folder, not a run"),
        ((moving, "--slide", "joint.C=1"), "PATH=LOW..HIGH"),
    ):
        done = told(*arguments, "-o", tmp_path / "page.html")
        assert done.exit_code == 2, done.output
        assert said in " ".join((done.output + done.stderr).split()), done.output
        assert "Traceback" not in done.output
    assert not (tmp_path / "page.html").exists()


def test_a_folder_that_is_not_there_is_told_before_the_work(tmp_path):
    done = told(tmp_path / "no.toml", "-o", tmp_path / "away" / "page.html")
    assert (
        done.exit_code == 2
        and f"there is no folder {tmp_path / 'away'}; make it first" in done.output.replace("\n", "")
    )
