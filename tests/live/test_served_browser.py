"""The served page in browsers: fields and their sentences, files and other browsers followed, saved, and
closed to pages from elsewhere.
"""

import pytest

from live.browsers import drag, drawn, needs_browser
from vfife.modelfile import load, loads

pytest.importorskip("starlette")
pytest.importorskip("uvicorn")

pytestmark = needs_browser
FIELD = '[id="field-joint.C.clearance"]'


def runs(page, wanted):
    """Waits until the model that is seen to run has a clearance (m) of C."""
    page.wait_for_function(
        "() => shell.frame && !shell.next && shell.frame.contentWindow.live.running.store.end > 1"
    )
    page.wait_for_function(
        "(wanted) => JSON.parse(shell.frame?.contentDocument.getElementById('given').textContent ??"
        " '{}').model?.includes(wanted)",
        arg=f"\nclearance = {wanted}\n",
    )


@pytest.mark.system("a browser")
def test_a_field_is_edited_and_wrong_values_get_the_sentence_of_the_model_there(visit, bar):
    page = visit()
    runs(page, "0.0002")
    assert page.evaluate("() => window.struck ?? shell.frame.contentWindow.struck") is None
    page.keyboard.press("Control+e")
    page.locator("details[data-table='joint.C'] summary").first.click()
    field = page.locator(FIELD)
    field.fill("0.24 mm")
    field.press("Enter")
    runs(page, "0.00024")
    assert page.locator("#save").is_enabled()
    field.fill("2 kg")
    field.press("Enter")
    row = page.locator(".row", has=field)
    row.locator(".fault:not(:empty)").wait_for()
    try:
        loads(bar.read_text("utf-8"), [("joint.C.clearance", "2 kg")])
    except ValueError as error:
        assert row.locator(".fault").inner_text() == str(error).split(", ", 1)[1].replace(
            " (given by set)", ""
        )
    assert field.get_attribute("aria-invalid") == "true"
    runs(page, "0.00024")
    assert load(bar).joints["C"].clearance == 0.0002
    field.fill("0.25 mm")
    field.press("Enter")
    runs(page, "0.00025")
    law = page.locator('[id="field-joint.C.contact.law"]')
    law.select_option("kelvin-voigt")  # whose parameters are other ones, and are missing
    page.locator('.row:has([id="field-joint.C.contact.damping_coefficient"]) .fault:not(:empty)').wait_for()
    page.locator("#faults button").click()
    assert law.input_value() == "lankarani-nikravesh"
    page.keyboard.press("Control+s")
    page.wait_for_function("() => shell.model.saved")
    assert bar.read_text("utf-8").startswith("# kept\n") and 'clearance = "0.25 mm"' in bar.read_text("utf-8")


@pytest.mark.system("several browsers")
def test_browsers_follow_the_file_and_one_another(visit, bar):
    visit.session.pages.sliders = True
    one, other = visit(), visit(viewport={"width": 390, "height": 780}, color_scheme="dark")
    for page in (one, other):
        runs(page, "0.0002")
        page.wait_for_function("() => shell.frame.contentWindow.live.sliders.inputs.length === 1")
    one.frame_locator("iframe").locator("#speed").fill("-2.5")
    bar.write_text(bar.read_text("utf-8").replace("clearance = 0.0002", "clearance = 0.0003"), "utf-8")
    visit.session.pages.sliders = False
    for page in (one, other):
        runs(page, "0.0003")
    assert one.frame_locator("iframe").locator("#speed").input_value() == "-2.5"
    other.click("#edit")
    other.click("#tab-text")
    other.locator("#text").fill(bar.read_text("utf-8").replace("clearance = 0.0003", "clearance = 0.00022"))
    for page in (one, other):
        runs(page, "0.00022")
    assert other.evaluate("() => document.documentElement.scrollWidth <= window.innerWidth")
    one.click("#undo")
    runs(other, "0.0003")


def test_a_page_from_elsewhere_gets_nothing(visit):
    context = visit.browser.new_context()
    context.route(
        "http://elsewhere.example/**",
        lambda route: route.fulfill(body="<p>another page</p>", content_type="text/html"),
    )
    page = context.new_page()
    page.goto("http://elsewhere.example/")
    asked = (
        "async ([url, how]) => { try { const a = await fetch(url, how); return a.type + a.status; } catch {"
        " return 'refused'; } }"
    )
    address = visit.serving.address
    assert page.evaluate(asked, [f"{address}shelf", {}]) == "refused"
    sent = {
        "method": "POST",
        "mode": "no-cors",
        "body": '{"gallery": "squeezer"}',
        "headers": {"content-type": "text/plain"},
    }
    assert page.evaluate(asked, [f"{address}open", sent]) in ("opaque0", "refused")
    assert "gallery-squeezer" not in visit.session.shelf.documents
    page.evaluate(
        "(url) => { document.body.append(Object.assign(document.createElement('iframe'), { src: url })); }",
        address,
    )
    page.wait_for_timeout(300)
    assert all(
        "vfife" not in (frame.content() if frame.url.startswith("http") else "") for frame in page.frames[1:]
    )
    context.close()


@pytest.mark.system("a browser")
def test_the_gallery_is_where_it_begins(visit):
    page = visit("")
    card = page.locator(".card", has_text="double pendulum").first
    card.wait_for()
    page.wait_for_function("() => [...document.querySelectorAll('.card img')][0].naturalWidth > 0")
    card.press("Enter")
    page.wait_for_function("() => shell.frame && shell.model.id === 'gallery-double_pendulum'")
    assert page.locator("#save").inner_text() == "Save as …"


@pytest.mark.system("a browser")
def test_a_point_is_dragged_taken_back_and_saved(visit, bar):
    before = bar.read_text("utf-8")
    page = visit()
    runs(page, "0.0002")
    drawn(page)
    curve = page.evaluate("() => shell.sketch.drawing.curves.flat(2).length")
    assert curve > 500
    drag(page, "s.drawing.place('crank.end')", 25, -20)
    page.wait_for_function("() => shell.model.version === 2")
    dragged = visit.session.shelf.documents["file-1"].text
    crank = loads(dragged).bodies["crank"]
    assert crank.length != loads(before).bodies["crank"].length and crank.angle > 0.02
    assert page.locator("#text").input_value() == dragged and dragged.startswith("# kept\n")
    assert bar.read_text("utf-8") == before  # nothing is written before Save
    page.keyboard.press("Control+z")
    page.wait_for_function("() => shell.model.version === 3")
    assert visit.session.shelf.documents["file-1"].text == before
    page.click("#redo")
    page.wait_for_function("() => shell.model.version === 4")
    page.click("#save")
    page.wait_for_function("() => shell.model.saved")
    assert bar.read_text("utf-8") == dragged
    page.click("#draw")
    page.wait_for_function("() => shell.frame && !shell.next && shell.frame.contentWindow.live")
    page.wait_for_function(
        "(length) => JSON.parse(shell.frame.contentDocument.getElementById('given').textContent)"
        ".model.includes(`length = ${length}`)",
        arg=repr(crank.length),
    )


@pytest.mark.system("a browser")
def test_a_drawing_that_does_not_close_is_a_draft_until_it_does(visit, bar):
    before = bar.read_text("utf-8")
    page = visit(viewport={"width": 1000, "height": 700})
    runs(page, "0.0002")
    drawn(page)
    page.evaluate("() => shell.sketch.choose({ body: 'coupler' })")
    field = page.locator("#chosen input")
    field.fill("50")
    field.press("Enter")
    page.wait_for_function("() => shell.draft && shell.sketch.drawing.gaps.length === 1")
    assert "open" in page.locator("#why").inner_text()
    assert loads(page.locator("#text").input_value()).bodies["coupler"].length == 0.05
    page.keyboard.press("Control+s")
    page.locator("#message:not([hidden])").wait_for()
    assert visit.session.shelf.documents["file-1"].text == bar.read_text("utf-8") == before
    field.fill("280")
    field.press("Enter")
    page.wait_for_function("() => !shell.draft && shell.model.version === 2")
    assert page.locator("#why").inner_text() == ""
    assert loads(visit.session.shelf.documents["file-1"].text).bodies["coupler"].length == 0.28
