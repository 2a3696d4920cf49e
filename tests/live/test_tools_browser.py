"""The tools of the drawing in a browser: each adds, changes or deletes parts by operations of the server, so
that the text is a valid model after each; a refusal is shown at its place and changes nothing.
"""

import pytest

from live.browsers import drag, drawn, needs_browser, pixel
from vfife.errors import ModelError
from vfife.live.sketch.operations import apply
from vfife.modelfile import loads

pytest.importorskip("starlette")
pytest.importorskip("uvicorn")

pytestmark = [needs_browser, pytest.mark.system("a browser")]
FREE = "[0.1, 0.3]"  # a place of the paper
COUPLER = "s.drawing.inBody(1, [0.06, 0])"  # a place on the coupler


class Drawing:
    """The drawing of a model in a browser, with its mouse and the text that the server has."""

    def __init__(self, page, session):
        self.page, self.document = page, session.shelf.documents[page.evaluate("() => shell.model.id")]

    def settle(self):
        """Wait for all operations, and for a frame, in which the paper may move."""
        self.page.evaluate("() => shell.sketch.queue")
        self.page.evaluate("() => new Promise((done) => requestAnimationFrame(() => setTimeout(done)))")

    def use(self, tool):
        self.page.click(f"[data-tool={tool}]")
        self.settle()

    def click(self, *places):
        for place in places:
            self.page.mouse.click(*pixel(self.page, place))
            self.settle()

    def fields(self):
        return self.page.locator("#chosen")

    @property
    def sentence(self):
        """The refusal at its place; None without one."""
        return (
            self.page.locator("#bubble").inner_text() if self.page.locator("#bubble").is_visible() else None
        )

    @property
    def model(self):
        """The model of the server, whose text the page shows."""
        assert self.page.locator("#text").input_value() == self.document.text
        return loads(self.document.text)


@pytest.fixture
def drawing(visit):
    page = visit(viewport={"width": 1200, "height": 800})
    page.wait_for_function("() => window.shell?.model")
    drawn(page)
    return Drawing(page, visit.session)


def test_a_mechanism_is_drawn_from_nothing(visit):
    page = visit("")
    page.click("#new")
    page.wait_for_function(
        "() => shell.sketch.drawing?.closed && 0.4 * shell.sketch.view.scale < shell.sketch.view.box[1]"
    )
    drawing = Drawing(page, visit.session)
    drawing.use("point")
    drawing.click("[0.12, 0]")
    drawing.use("body")
    drawing.click("s.drawing.place('crank.end')", "[0.1, 0.15]", "s.drawing.place('bar.end')", "[0.12, 0]")
    assert {one.sides for one in drawing.model.joints.values()} == {
        (("ground", "A"), ("crank", "start")),
        (("crank", "end"), ("bar", "start")),
        (("bar", "end"), ("bar-2", "start")),
        (("ground", "B"), ("bar-2", "end")),
    }
    assert page.evaluate("() => shell.sketch.drawing.poses.length") > 10
    drawing.page.keyboard.press("Escape")
    drawing.click("s.view.from(s.driverArc(s.drawing.bodies[0])[6])")
    speed = drawing.fields().get_by_label("speed in rpm")
    assert speed.input_value() == "60"
    speed.fill("90")
    speed.press("Enter")
    page.wait_for_function("() => shell.model.version === 5")
    assert drawing.model.drivers["crank"].steady_speed == pytest.approx(9.424778)


def test_a_body_is_added_and_joined_by_clicks(drawing):
    before = drawing.document.text
    drawing.use("body")
    drawing.click("s.drawing.place('coupler.end')", FREE)
    bar = drawing.model.bodies["bar"]
    [held] = [one for one in drawing.model.joints.values() if one.journal == "bar.start"]
    assert held.bearing == "coupler.end" and "bar.end" not in str(drawing.model.joints)
    assert drawing.page.evaluate("() => shell.sketch.chosen.body") == "bar"
    assert float(drawing.fields().get_by_label("length in mm").input_value()) == pytest.approx(
        1e3 * bar.length, 1e-3
    )
    drawing.use("joint")
    drawing.fields().locator("select").select_option("slot")
    drawing.click("s.drawing.place('bar.end')", "s.drawing.place('bar.end')")  # twice: held on the ground
    [guide] = [one for one in drawing.model.joints.values() if one.journal == "bar.end"]
    assert guide.kind == "slider" and guide.turning and guide.bearing.startswith("ground.")
    drawing.page.keyboard.press("Control+z")
    drawing.page.keyboard.press("Control+z")
    drawing.page.wait_for_function(
        "() => !document.getElementById('redo').disabled && shell.model.undo === 0"
    )
    assert drawing.document.text == before


def test_a_drawn_guide_is_turned_in_its_field(drawing):
    """It is drawn horizontally; its direction is a number, and undone as any other change."""
    drawing.use("body")
    drawing.click("s.drawing.place('coupler.end')", FREE)
    drawing.use("joint")
    drawing.fields().locator("select").select_option("slot")
    drawing.click("s.drawing.place('bar.end')", "s.drawing.place('bar.end')")
    drawn = drawing.document.text
    drawing.use("select")
    drawing.click("s.drawing.place('bar.end')")
    field = drawing.fields().get_by_label("direction in °")
    assert field.input_value() == "0"
    version = drawing.page.evaluate("() => shell.model.version")
    field.fill("30")
    field.press("Enter")
    drawing.page.wait_for_function(f"() => shell.model.version === {version + 1}")
    [guide] = [one for one in drawing.model.joints.values() if one.journal == "bar.end"]
    assert guide.direction == pytest.approx((0.75**0.5, 0.5), abs=1e-6)
    drawing.page.evaluate("() => document.activeElement.blur()")
    drawing.page.keyboard.press("Control+z")
    drawing.page.wait_for_function(f"() => shell.model.version === {version + 2}")
    assert drawing.document.text == drawn


def test_bodies_are_joined_where_they_are_clicked_and_a_drag_draws_a_body(drawing):
    drawing.use("body")
    drag(drawing.page, FREE, 60, 80)
    drawing.page.wait_for_function("() => shell.model.version === 2")
    drawing.settle()
    assert not any("bar" in one.journal for one in drawing.model.joints.values())
    drawing.use("joint")
    drawing.fields().locator("select").select_option("clearance")
    drawing.click("s.drawing.place('bar.start')", COUPLER)
    [joint] = [one for one in drawing.model.joints.values() if "bar.start" in (one.bearing, one.journal)]
    assert {joint.bearing, joint.journal} == {"bar.start", "coupler.P"} and joint.clearance > 0.0
    assert drawing.model.bodies["coupler"].pins["P"] == pytest.approx((0.06, 0.0), abs=2e-3)
    assert drawing.document.version == 3  # the pin, the joint and its kind are one change


def test_points_forces_and_drivers_are_added_and_changed(drawing):
    drawing.use("point")
    drawing.click(FREE)
    assert drawing.model.points["B" if "B" in drawing.model.points else "E"] == pytest.approx(
        (0.1, 0.3), abs=0.01
    )
    drag(drawing.page, COUPLER, 40, 60)
    drawing.page.wait_for_function("() => shell.model.version === 3")
    drawing.settle()
    assert abs(drawing.model.bodies["coupler"].pins["P"][1]) > 0.02
    drawing.use("force")
    drawing.click("s.drawing.place('coupler.P')")
    assert drawing.model.loads["force"].force == (0.0, -10.0)
    field = drawing.fields().get_by_label("x in N")
    field.fill("25")
    field.press("Enter")
    drawing.page.wait_for_function("() => shell.model.version === 5")
    assert drawing.model.loads["force"].force == (25.0, -10.0)
    drawing.use("delete")
    drawing.click("s.view.from(s.driverArc(s.drawing.bodies[0])[6])")
    assert not drawing.model.drivers
    drawing.use("driver")
    drawing.click("s.drawing.inBody(0, [0.3, 0])")
    assert drawing.model.drivers["crank"].steady_speed == pytest.approx(6.283185)


def test_parts_are_deleted_and_restored(drawing):
    before = drawing.document.text
    drawing.use("delete")
    drawing.click("s.drawing.place('coupler.start')")
    assert "B" not in drawing.model.joints and "coupler" in drawing.model.bodies
    drawing.use("joint")  # two pins in one place: clicked twice they are joined, and not held on the ground
    drawing.click("s.drawing.place('coupler.start')", "s.drawing.place('coupler.start')")
    assert set(drawing.model.joints["B"].sides) == {("crank", "end"), ("coupler", "start")}
    drawing.page.keyboard.press("Escape")
    assert drawing.page.locator("[data-tool=select]").get_attribute("aria-pressed") == "true"
    drawing.click(COUPLER)
    drawing.page.keyboard.press("Delete")
    drawing.settle()
    assert set(drawing.model.bodies) == {"crank", "follower"} and "C" not in drawing.model.joints
    for left in (2, 1, 0):
        drawing.page.keyboard.press("Control+z")
        drawing.page.wait_for_function("(left) => shell.model.undo === left", arg=left)
    assert drawing.document.text == before


def test_an_answer_that_a_newer_one_overtakes_changes_nothing(drawing):
    """Two steps are undone, and the answer to the first arrives after that to the second."""
    before, late = drawing.document.text, []

    def hold(route):
        if late:
            return route.continue_()
        late.append((route, route.fetch()))

    drawing.use("point")
    drawing.click(FREE, "[0.2, 0.3]")
    drawing.page.route("**/undo", hold)
    for left in (1, 0):
        drawing.page.keyboard.press("Control+z")
        drawing.page.wait_for_function("(left) => shell.model.undo === left", arg=left)
    [(route, answer)] = late
    assert answer.json()["undo"] == 1
    with drawing.page.expect_response("**/undo"):
        route.fulfill(response=answer)
    drawing.settle()
    assert drawing.page.evaluate("() => shell.model.undo") == 0
    assert drawing.page.locator("#text").input_value() == drawing.document.text == before


def test_the_pivot_of_a_driven_crank_is_not_deleted_and_the_sentence_is_beside_it(drawing):
    before, version = drawing.document.text, drawing.document.version
    with pytest.raises(ModelError) as refused:
        apply(before, "delete", {"section": "joint", "name": "A"})
    drawing.use("delete")
    drawing.click("s.drawing.place('crank.start')")
    assert drawing.sentence and drawing.sentence.split(": ", 1)[1][:40] in str(refused.value)
    x, y = pixel(drawing.page, "s.drawing.place('crank.start')")
    box = drawing.page.locator("#bubble").bounding_box()
    assert box["x"] <= x <= box["x"] + box["width"] and abs(box["y"] - y) < 60
    drawing.model  # noqa: B018  # the page shows the text of the server
    assert (drawing.document.text, drawing.document.version) == (before, version)
    drawing.use("select")
    assert drawing.sentence is None


def test_a_tool_that_is_left_changes_nothing(drawing):
    before = drawing.document.text
    for tool in ("body", "joint"):
        drawing.use(tool)
        drawing.click("s.drawing.place('crank.end')")
        drawing.page.keyboard.press("Escape")
        drawing.click(FREE, FREE)
        drawing.use(tool)
        drawing.click(FREE)  # the first place of another body
        drawing.page.keyboard.press("Escape")
    drawing.use("force")
    drawing.click(FREE)
    assert "click one of its points" in drawing.sentence
    drawing.use("joint")
    drawing.click(FREE, FREE)
    assert "nothing to join" in drawing.sentence
    assert drawing.document.text == before and drawing.document.version == 1


def test_the_kind_of_a_joint_is_changed_in_its_menu_and_a_draft_is_taken_back_in_steps(drawing):
    drawing.click("s.drawing.place('coupler.end')")
    kind = drawing.fields().get_by_label("kind of C")
    assert kind.input_value() == "clearance"
    drawing.fields().get_by_label("clearance in mm").fill("0.3")
    drawing.page.keyboard.press("Enter")
    drawing.page.wait_for_function("() => shell.model.version === 2")
    assert drawing.model.joints["C"].clearance == pytest.approx(3e-4)
    kind.select_option("ideal")
    drawing.settle()
    assert drawing.model.joints["C"].kind == "ideal"
    drawing.click("s.drawing.place('crank.start')")
    drawing.fields().get_by_label("kind of A").select_option("clearance")  # refused: the crank is driven
    drawing.settle()
    assert "driven body" in drawing.sentence and drawing.model.joints["A"].kind == "ideal"
    assert drawing.fields().get_by_label("kind of A").input_value() == "ideal"
    drawing.use("body")
    for place in ("coupler.end", "coupler.start"):
        drawing.click("s.drawing.place('ground.A')", f"s.drawing.place('{place}')")
        assert drawing.page.evaluate("() => shell.draft !== null")
    assert "nothing can move" in drawing.page.locator("#why").inner_text()
    for count in (1, 0):
        drawing.page.click("#undo")
        drawing.page.wait_for_function(
            "(count) => shell.sketch.drawing.bodies.length === 3 + count && !shell.draft === !count",
            arg=count,
        )
    assert drawing.page.locator("#text").input_value() == drawing.document.text


def test_a_dragged_point_reads_in_the_resolution_of_lengths(drawing):
    """A link has a rounded length and angle, so its end lies off the grid by less than that."""
    drawing.use("select")
    drag(drawing.page, "s.drawing.place('crank.end')", 37, 23)
    drawing.settle()
    drawing.page.wait_for_function("() => !shell.sketch.drag && shell.sketch.chosen?.knot")
    step = drawing.page.evaluate("() => 1e3 * shell.sketch.drawing.resolution")
    for axis in "xy":
        shown = float(drawing.fields().get_by_label(f"{axis} in mm").input_value())
        assert shown == pytest.approx(round(shown / step) * step, abs=1e-9), shown
