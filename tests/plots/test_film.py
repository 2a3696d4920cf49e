"""Films of a run: where things are in them, what is drawn again, and files that are whole or not there."""

import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

import vfife
from vfife import gallery
from vfife.cli.app import app
from vfife.errors import StorageError, VfifeError
from vfife.plots import filmfiles
from vfife.plots.film import Film, frame_positions
from vfife.plots.filmfiles import animate
from vfife.simulation.result import Result

CLEARANCE = gallery.slider_crank_loose_pin().clearances["pin"].clearance


@cache
def run() -> Result:
    return vfife.simulate(
        gallery.slider_crank_loose_pin(), turns=0.25, outputs=360, companions=0, loop="data-driven"
    )


@cache
def film() -> Film:
    return Film(run(), run().reference, 24, 1.0, 64.0)


def test_the_crank_is_where_its_speed_takes_it() -> None:
    """Its end goes around a circle, by as much from frame to frame; a frame lies between two outputs."""
    shown = film()
    places = np.array(
        [
            next(one.at for one in moment if one.look.get("label") == "crank")
            for moment in shown.playback.frames
        ]
    )
    assert np.allclose(np.linalg.norm(places[:, 1] - places[:, 0], axis=1), 1e3 * 0.05, rtol=1e-4)  # mm
    angles = np.unwrap(np.arctan2(*(places[:, 1] - places[:, 0]).T[::-1]))
    assert np.allclose(np.diff(angles), np.radians(90.0) / 23, rtol=1e-4)
    assert not np.allclose(shown.at, np.rint(shown.at))


def test_a_journal_is_drawn_in_a_circle_of_its_play() -> None:
    """It touches the circle where it touches its bearing, and stays inside but for its penetration."""
    shown = film()
    assert shown.enlarged > 2.0 and f"{shown.enlarged:g} times as large" in shown.figure.get_suptitle()
    for moment in shown.playback.frames:
        circle = next(one.at for one in moment if one.rank == 9.1)
        journal = next(one.at[0] for one in moment if one.rank == 9.3)
        centre = circle[:-1].mean(axis=0)
        radius = np.linalg.norm(circle - centre, axis=1)
        assert np.allclose(radius, shown.enlarged * 1e3 * CLEARANCE)
        assert np.linalg.norm(journal - centre) < 1.1 * radius[0]


def test_curves_end_where_the_force_is() -> None:
    shown, result = film(), run()
    names = [curve.ax.get_title(loc="left") for curve in shown.curves]
    assert names == ["joint O", "joint crankpin", "joint pin"]
    joints = list(result.data.joint.values)
    force = result.channels["joint_force_max"].values[:, joints.index("pin")]
    assert np.allclose(shown.curves[2].y, 1e-3 * force)  # kN
    heads = [shown._head(shown.curves[2].y, k) for k in (0, 23)]
    assert heads == [shown.curves[2].y[0], shown.curves[2].y[-1]] and force.max() > 2e3


def test_only_what_moves_is_drawn_again() -> None:
    """The ground's sign and the rails are part of the background; pixels beside the mechanism stay as they
    are.
    """
    shown = film()
    below = [shown.playback.frames[0][k] for k in sorted(shown.playback.background)]
    assert any("hatch" in one.look for one in below) and any(one.text == "O" for one in below)
    assert not any(one.look.get("label") for one in below)  # bodies
    pictures = [
        np.array(picture).reshape(shown.size[1], shown.size[0], 4)[..., :3] for picture in shown.pictures()
    ]
    changed = np.any([(one != pictures[0]).any(axis=2) for one in pictures], axis=0)
    assert 0.01 < changed.mean() < 0.3 and (pictures[0] < 128).any()


def test_frames_are_no_more_than_outputs_and_end_with_the_run() -> None:
    assert list(frame_positions(5, 2, 240)) == [2.0, 3.0, 4.0]
    assert list(frame_positions(9, 0, 3)) == [0.0, 4.0, 8.0]


@pytest.mark.system("draws a film")
def test_a_gif_has_its_frames_for_as_long(tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    assert animate(run(), tmp_path / "a.gif", 6, 20.0, progress=lambda k, n: told.append((k, n))) == (6, 0.3)
    with Image.open(tmp_path / "a.gif") as image:
        assert (
            image.n_frames == 6
            and image.info["duration"] == 50
            and image.info["loop"] == 0
            and image.size == (960, 540)
        )
        assert image.convert("RGB").getpixel((2, 2)) == (255, 255, 255)
    assert told == [(k, 6) for k in range(1, 7)] and [path.name for path in tmp_path.iterdir()] == ["a.gif"]


def test_few_equilibria_are_shown_slowly(tmp_path: Path) -> None:
    frames, seconds = animate(vfife.simulate(gallery.toggle_press()), tmp_path / "a.gif")
    with Image.open(tmp_path / "a.gif") as image:
        assert (
            image.n_frames == frames
            and 1e-3 * image.info["duration"] * frames == pytest.approx(seconds, abs=0.01 * frames)
            and seconds >= 3.0
        )


def test_a_film_that_is_stopped_leaves_what_was_there(tmp_path: Path) -> None:
    path = tmp_path / "a.gif"
    path.write_text("before")

    def stop(k: int, n: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        animate(run(), path, 6, progress=stop)
    assert path.read_text() == "before" and [one.name for one in tmp_path.iterdir()] == ["a.gif"]


@pytest.mark.parametrize(
    ("name", "given", "says"),
    [
        ("a.avi", {}, r"\.gif, \.mp4"),
        ("a.gif", {"frames": 1}, "frames: 1 is not between 2"),
        ("a.gif", {"rate": 100.0}, "frames a second: 100"),
    ],
)
def test_what_is_no_film_is_refused(name: str, given: dict[str, float], says: str, tmp_path: Path) -> None:
    with pytest.raises(VfifeError, match=says):
        animate(run(), tmp_path / name, **given)
    assert not list(tmp_path.iterdir())


def test_mp4_without_its_writer_gets_a_sentence(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(VfifeError, match=r'pip install "vfife\[video\]", or write \.gif .*"\.\[video\]"'):
        run().animate(tmp_path / "a.mp4")


def test_an_mp4_has_its_frames(tmp_path: Path) -> None:
    imageio_ffmpeg = pytest.importorskip(
        "imageio_ffmpeg", reason="MP4 is written by the extra video, which is not installed here"
    )
    animate(run(), tmp_path / "a.mp4", 10, 25.0)
    assert imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "a.mp4")) == (10, pytest.approx(0.4))


def test_an_encoder_that_fails_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Whatever it said last, and no file is left."""
    program = tmp_path / "encoder"
    program.write_text("#!/bin/sh\necho 'no room left' >&2\nexit 3\n")
    program.chmod(0o755)
    monkeypatch.setattr(filmfiles, "_ffmpeg", lambda path: str(program))
    with pytest.raises(StorageError, match="ffmpeg could not write the film: no room left"):
        animate(run(), tmp_path / "a.mp4", 4)
    assert [one.name for one in tmp_path.iterdir()] == ["encoder"]


def test_the_command_writes_one_and_replaces_none(tmp_path: Path) -> None:
    run().save(tmp_path / "run.sqlite")
    line = ["animate", str(tmp_path), "-o", str(tmp_path / "a.gif"), "--frames", "4"]
    said = CliRunner().invoke(app, line)
    assert said.exit_code == 0 and "4 frames, 0.16 s long" in said.stdout
    again = CliRunner().invoke(app, line)
    assert again.exit_code == 2 and "--force" in again.stderr


def test_names_lie_on_no_pin_in_any_frame() -> None:
    result = vfife.simulate(
        gallery.compressor(turns=1.0), outputs=120, companions=0, loop="data-driven", reference=False
    )
    film = Film(result, None, 24, 1.0, 60.0)
    ax = film.playback.ax
    scale = 72.0 * film.figure.get_figwidth() * ax.get_position().width / np.ptp(ax.get_xlim())
    for calls in film.playback.frames:
        pins = [scale * call.at[0] for call in calls if call.look.get("marker") == "o" and call.rank >= 7.0]
        names = [call for call in calls if call.method == "annotate" and call.text]
        assert len(pins) >= 3 and len(names) >= 2
        for call in names:
            away = np.abs(np.array(pins) - (scale * call.at[0] + call.at[1]))
            assert not (away < (3.0 * len(call.text), 6.0)).all(axis=1).any(), call.text
