"""The served page as programs see it: who is answered, what may be opened and written, what is told when a
file or a model changes.
"""

import asyncio
import http.client
import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from typer.testing import CliRunner

from cli.conftest import hear
from live.pages import scripts_of
from vfife import gallery
from vfife.cli.app import app
from vfife.modelfile import dump, load, loads

pytest.importorskip("starlette")
pytest.importorskip("uvicorn")

from vfife.live.server.app import served
from vfife.live.server.session import MOST_BROWSERS, Mailbox, Runs, Session, text_of

TEXT = "# kept\n" + dump(gallery.four_bar_case_b())


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("models")
    (found / "bar.toml").write_text(TEXT, "utf-8")
    (found / "pyproject.toml").write_text("[project]\nname = 'other'\n", "utf-8")
    (found.parent / "secret.toml").write_text(TEXT, "utf-8")
    (found / "out.toml").symlink_to(found.parent / "secret.toml")
    return found


class Client:
    """Asks a session as a browser does."""

    def __init__(self, serving, session):
        self.serving, self.session = serving, session
        self.secret = serving.address.rsplit("/", 2)[1]

    def ask(self, where, sent=None, secret=None, method=None, **headers):
        connection = http.client.HTTPConnection("127.0.0.1", self.serving.port, timeout=20)
        body = None if sent is None else json.dumps(sent)
        given = {"Content-Type": "application/json"} if sent is not None else {}
        connection.request(
            method or ("GET" if sent is None else "POST"),
            f"/{secret or self.secret}/{where}",
            body,
            given | headers,
        )
        answer = connection.getresponse()
        content = answer.read()
        connection.close()
        return answer.status, (
            json.loads(content)
            if answer.getheader("content-type", "").startswith("application/json")
            else content.decode()
        )

    def opened(self, name="bar.toml"):
        status, found = self.ask("open", {"file": name})
        assert status == 200
        return found

    def heard(self, wanted, act):
        """What is told of a kind while ``act`` is done; waits 20 s, as signs of life keep the socket open."""
        until = time.monotonic() + 20.0
        connection = http.client.HTTPConnection("127.0.0.1", self.serving.port, timeout=20)
        connection.request("GET", f"/{self.secret}/events")
        answer = connection.getresponse()
        act()
        for line in iter(answer.readline, b""):
            if line.startswith(b"data: ") and (event := json.loads(line[6:]))["kind"] == wanted:
                connection.close()
                return event
            assert time.monotonic() < until, f"no event of the kind {wanted}"
        raise AssertionError("the events ended")


@pytest.fixture(scope="module")
def client(folder):
    session = Session(folder, sliders=False)
    with served(session) as serving:
        yield Client(serving, session)


def test_only_whoever_knows_the_address_is_answered(client):
    assert client.ask("")[0] == 200
    here = f"127.0.0.1:{client.serving.port}"
    for secret, headers in (
        ("wrong" * 6, {}), (client.secret[:-1], {}), (None, {"Host": f"evil.example:{client.serving.port}"}),
        (None, {"Host": "127.0.0.1"}),
        (None, {"Origin": "http://evil.example"}), (None, {"Origin": "null"}),
        (None, {"Origin": f"https://{here}"}),
        (None, {"Origin": f"http://127.0.0.1:{client.serving.port + 1}"}),
        (None, {"Sec-Fetch-Site": "cross-site"}),
        (None, {"Sec-Fetch-Site": "same-site", "Sec-Fetch-Dest": "iframe"}),
    ):  # fmt: skip
        for where, sent in (("", None), ("shelf", None), ("open", {"gallery": "squeezer"}), ("events", None)):
            status, said = client.ask(where, sent, secret, **headers)
            assert status == 403 and "four" not in said, (secret, headers, where)
    assert (
        client.ask("", Origin=f"http://{here}")[0]
        == client.ask("", **{"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Dest": "document"})[0]
        == 200
    )
    assert client.ask("open", {"gallery": "squeezer"}, **{"Content-Type": "text/plain"})[0] == 403
    assert "gallery-squeezer" not in client.session.shelf.documents


def test_it_is_reached_from_this_machine_alone(client):
    """It listens on the loop of the machine; another of its addresses answers nobody."""
    with socket.socket() as other, pytest.raises(OSError):
        other.settimeout(2)
        other.connect(("127.0.0.2", client.serving.port))


def test_what_may_be_opened_is_the_gallery_and_the_models_of_the_folder(client):
    _, shelf = client.ask("shelf")
    assert shelf["files"] == [{"name": "bar.toml", "title": "four-bar, case b"}] and {
        one["name"] for one in shelf["gallery"]
    } == set(gallery.__all__)
    for name in ("pyproject.toml", "out.toml", "../secret.toml", "/etc/passwd", "", "bar.toml/"):
        assert client.ask("open", {"file": name})[0] == 404
    for where in ("shell.py", "..%2fpage.css", "model/none", "model/none/page", "drawing/os"):
        assert client.ask(where)[0] == 404
    assert client.ask("open", {"gallery": "__all__"})[0] == 404
    status, picture = client.ask("drawing/bar.toml")
    assert status == 200 and "<svg" in picture, "a model of the folder is drawn as those of the gallery"
    assert client.ask("drawing/out.toml")[0] == client.ask("drawing/pyproject.toml")[0] == 404


def test_what_may_be_written_is_a_new_model_of_the_folder(client, folder):
    _, found = client.ask("open", {"name": "mine.toml", "text": TEXT})
    before = sorted(folder.iterdir())
    for name in (
        "../mine.toml",
        "/tmp/mine.toml",
        "sub/mine",
        ".hidden",
        "a\x00b",
        "mine.py/../x",
        "pyproject",
        "bar.toml",
        "out.toml",
        "x" * 200,
    ):
        status, said = client.ask(f"model/{found['id']}/save", {"name": name})
        assert status == 409, name
        assert said["faults"][0]["said"]
    assert sorted(folder.iterdir()) == before and (folder / "bar.toml").read_text("utf-8") == TEXT
    status, saved = client.ask(f"model/{found['id']}/save", {"name": "mine"})
    assert (
        status == 200 and saved["file"] == "mine.toml" and (folder / "mine.toml").read_text("utf-8") == TEXT
    )
    (folder / "mine.toml").unlink()


def test_a_changed_value_runs_and_a_wrong_one_gets_the_sentence_of_the_model(client):
    found = client.opened()
    where = f"model/{found['id']}"
    status, changed = client.ask(
        f"{where}/set",
        {"changes": [{"path": ["joint", "C", "clearance"], "value": "0.31 mm"}], "version": found["version"]},
    )
    assert status == 200 and changed["text"].startswith("# kept") and not changed["saved"]
    status, page = client.ask(f"{where}/page")
    assert status == 200 and loads(scripts_of(page)["model"]).joints["C"].clearance == pytest.approx(
        0.31e-3, rel=1e-12
    )
    status, said = client.ask(
        f"{where}/set",
        {"changes": [{"path": ["joint", "C", "clearance"], "value": "-1 mm"}], "version": changed["version"]},
    )
    assert status == 422
    (fault,) = said["faults"]
    assert fault["where"] == "[joint.C] clearance"
    try:
        loads(TEXT, [("joint.C.clearance", "-1 mm")])
    except ValueError as error:
        assert fault["said"] == str(error).split(", ", 1)[1].replace(" (given by set)", "")
    assert client.ask(where)[1]["text"] == changed["text"]
    late = {"changes": [{"path": ["name"], "value": '"late"'}], "version": found["version"]}
    assert client.ask(f"{where}/set", late)[0] == 409
    assert client.ask(f"{where}/undo", {})[1]["text"] == TEXT


def test_changes_that_are_sound_together_are_taken_together(client):
    found = client.opened()
    law = {"path": ["joint", "C", "contact", "law"], "value": '"kelvin-voigt"'}
    asked = {"changes": [law], "version": found["version"]}
    status, said = client.ask(f"model/{found['id']}/set", asked)
    assert status == 422 and said["draft"]["values"]["joint"]["C"]["contact"]["law"] == "kelvin-voigt"
    missing = [
        {"path": ["joint", "C", "contact", one["where"].split()[-1]], "value": "100"}
        for one in said["faults"]
    ]
    assert missing
    status, said = client.ask(f"model/{found['id']}/set", {**asked, "changes": [law, *missing]})
    assert status == 200
    assert client.ask(f"model/{found['id']}/undo", {})[1]["text"] == TEXT


@pytest.mark.parametrize(
    "sent",
    [
        None,
        [],
        "text",
        {"changes": 3, "version": 1},
        {"changes": [{"path": [], "value": "1"}], "version": 1},
        {},
    ],
)
def test_what_makes_no_sense_is_refused(client, sent):
    found = client.opened()
    status, said = client.ask(
        f"model/{found['id']}/set", sent, method="POST", **{"Content-Type": "application/json"}
    )
    assert status in (400, 404, 422) and said["faults"]


@pytest.mark.parametrize("wrong", [None, 5, ["a"], {}, True])
def test_what_is_no_text_is_refused_in_words(client, wrong):
    where = f"model/{client.opened()['id']}"
    asked = [
        ("open", {"name": "x", "text": wrong}),
        ("open", {"name": wrong, "text": TEXT}),
        ("open", {"file": wrong}),
        ("open", {"gallery": wrong}),
    ]
    asked += [
        (f"{where}/text", {"text": wrong, "version": 1}),
        *([(f"{where}/save", {"name": wrong})] if wrong is not None else []),
    ]
    for place, sent in asked:
        status, said = client.ask(place, sent)
        assert status == 422 and "is to be a text" in said["faults"][0]["said"], (place, sent, said)


def test_quick_changes_start_no_more_threads(folder, monkeypatch):
    """Of a hundred and fifty changes only the last page is wanted: there were 116 threads."""
    session = Session(folder, sliders=False)
    document = session.shelf.from_text("quick", TEXT)
    begun = threading.Event()
    session.pages.page = lambda document, full=False: begun.wait(10.0)
    begun_threads: list[threading.Thread] = []
    start, here = threading.Thread.start, threading.current_thread()

    def noted(self: threading.Thread) -> None:
        """Threads that other sessions begin meanwhile, in threads of theirs, are none of this one's."""
        if threading.current_thread() is here:
            begun_threads.append(self)
        start(self)

    monkeypatch.setattr(threading.Thread, "start", noted)
    for k in range(150):
        session.change(document.id, lambda one, k=k: one.take(f"# {k}\n{TEXT}"))
    monkeypatch.undo()
    assert not begun_threads and len(session.pages.prepared) <= 1
    begun.set()
    session.close()


def test_a_page_that_was_waited_for_is_that_of_the_last_change(folder, monkeypatch):
    session, first, last = Session(folder, sliders=False), "the first", "the last"
    document, made = (
        session.shelf.from_text("quick", re.sub(r'name = ".*"', f'name = "{first}"', TEXT, count=1)),
        [],
    )
    monkeypatch.setattr(
        "vfife.live.server.pages.live_page",
        lambda mechanism, *more: made.append(mechanism.name) or mechanism.name,
    )
    with session.pages.building:
        waiting = [threading.Thread(target=session.pages.page, args=(document,)) for _ in range(20)]
        for one in waiting:
            one.start()
        document.take(re.sub(r'name = ".*"', f'name = "{last}"', TEXT, count=1))
    for one in waiting:
        one.join(10.0)
    assert [name for name in made if name in (first, last)] == [
        last
    ]  # another session may make pages of others meanwhile
    session.close()


def test_a_browser_that_does_not_read_costs_one_event_of_each_kind():
    mailbox = Mailbox()
    for k in range(10_000):
        for which in "ab":
            mailbox.put(*text_of({"kind": "model", "id": which, "text": f"{k}"}))
    assert len(mailbox.events) == 2
    with ThreadPoolExecutor(1) as pool:  # a browser of another test may have left a loop in this thread
        key, text = pool.submit(lambda: asyncio.run(mailbox.take(1.0))).result()
    assert key == ("model", "a") and '"9999"' in text


def test_more_browsers_than_there_can_be_are_refused(folder):
    """In a session of its own: what of a browser that has gone is noticed with the next sign of life at the
    latest.
    """
    sockets, answers = [], []
    session = Session(folder, sliders=False)
    with served(session) as serving:
        secret = Client(serving, session).secret
        for _ in range(MOST_BROWSERS + 3):
            one = socket.create_connection(("127.0.0.1", serving.port), timeout=20)
            sockets.append(one)
            one.sendall(f"GET /{secret}/events HTTP/1.1\r\nHost: 127.0.0.1:{serving.port}\r\n\r\n".encode())
            answers.append(one.recv(15))
        for one in sockets:
            one.close()
    assert answers.count(b"HTTP/1.1 200 OK") <= MOST_BROWSERS and b"HTTP/1.1 503 Se" in answers


def test_a_file_is_followed_and_a_browser_does_not_write_over_what_came(client, folder):
    found = client.opened()
    path = folder / "bar.toml"
    where = f"model/{found['id']}"
    newer = TEXT.replace("# kept", "# another program")
    event = client.heard("model", lambda: path.write_text(newer, "utf-8"))
    assert (event["by"], event["text"], event["saved"]) == ("file", newer, True)
    event = client.heard("model", lambda: path.write_text(newer + "\n[nothing]\nx = 1\n", "utf-8"))
    assert event["text"] == newer and "nothing" in event["faults"][0]["said"]
    event = client.heard("model", lambda: path.write_text(TEXT, "utf-8"))
    assert event["text"] == TEXT and event["faults"] == []
    client.ask(f"{where}/text", {"text": "# here\n" + TEXT, "version": event["version"]})
    with client.session.lock:  # before it is looked at again
        path.write_text(newer, "utf-8")
        assert client.session.shelf[found["id"]].saved is False
        with pytest.raises(ValueError, match="another program"):
            client.session.shelf[found["id"]].save()
    assert path.read_text("utf-8") == newer
    assert client.ask(f"{where}/undo", {})[1]["text"] == "# here\n" + TEXT
    assert client.ask(f"{where}/save", {})[1]["saved"] and path.read_text("utf-8") == "# here\n" + TEXT
    event = client.heard("gone", path.unlink)
    assert "was deleted" in event["said"]
    assert client.ask(f"{where}/text", {"text": TEXT, "version": client.ask(where)[1]["version"]})[0] == 200
    assert client.ask(f"{where}/save", {})[1]["saved"] and path.read_text("utf-8") == TEXT


def test_a_model_that_cannot_run_in_a_page_gets_a_sentence(client):
    long = re.sub(r"elements = \d+", "elements = 600", dump(gallery.elastic_pendulum()))
    status, found = client.ask("open", {"name": "<b>.toml", "text": long})
    assert status == 200
    status, said = client.ask(f"model/{found['id']}/page")
    assert status == 422 and "there are 600 here" in said and "<script" not in said


@pytest.mark.system("runs a model in a server")
def test_a_saved_model_is_run_beside_its_file(client, folder):
    found = client.opened()
    small = {
        "changes": [
            {"path": ["run", "turns"], "value": "0.02"},
            {"path": ["run", "companions"], "value": "0"},
        ],
        "version": found["version"],
    }
    where = f"model/{found['id']}"
    assert client.ask(f"{where}/set", small)[0] == 200
    assert client.ask(f"{where}/run", {})[0] == 409
    assert client.ask(f"{where}/save", {})[0] == 200
    event = client.heard("run", lambda: client.ask(f"{where}/run", {}))
    assert (
        event["code"] == 0 and "bar" in event["said"] and (folder / "runs" / "bar" / "run.sqlite").is_file()
    )
    assert load(folder / "runs" / "bar" / "model.toml").settings.turns == 0.02
    client.ask(f"{where}/undo", {})
    client.ask(f"{where}/save", {})


def test_sliders_come_when_the_mechanism_already_runs(folder):
    session = Session(folder, slide=["joint.C.clearance=0.2..0.21mm"])
    with served(session) as serving:
        client = Client(serving, session)
        found = client.opened()
        session.pages.first = found["id"]
        told = threading.Event()
        event = client.heard("sliders", lambda: [told.set(), client.ask(f"model/{found['id']}/page")])
        assert event["version"] == found["version"] and "said" not in event
        pages = [client.ask(f"model/{found['id']}/page{query}")[1] for query in ("", "?sliders=1")]
        assert [len(scripts_of(page)["slides"]) for page in pages] == [0, 1]


@pytest.mark.system("starts a process and sends it a signal")
def test_ctrl_c_ends_it_with_browsers_connected(folder):
    command = [sys.executable, "-m", "vfife", "live", str(folder / "bar.toml"), "--no-browser"]
    process = subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder,
        env=os.environ,
        preexec_fn=hear,
    )
    address = process.stdout.readline()
    port, where = re.search(r":(\d+)(/.*/)#", address).groups()
    connection = http.client.HTTPConnection("127.0.0.1", int(port), timeout=20)
    connection.request("GET", f"{where}events")
    assert connection.getresponse().readline().startswith(b"retry")
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=20)
    assert (
        process.returncode == 130
        and "Stopped by Ctrl-C" in said
        and "Traceback" not in said
        and "terminate" not in said
    )


def told(*arguments):
    done = CliRunner().invoke(app, ["live", *map(str, arguments)])
    return done.exit_code, " ".join((done.output + done.stderr).split())


def test_what_keeps_it_from_being_served_is_a_sentence(folder, monkeypatch, client):
    code, said = told(folder / "bar.toml", "--no-browser", "--port", client.serving.port)
    assert code == 2 and f"--port {client.serving.port}" in said and "name another one" in said
    code, said = told(folder / "none.toml", "--no-browser")
    assert code == 2 and "cannot be read" in said
    code, said = told("--no-browser", "--set", "joint.C.clearance=1 mm")
    assert code == 2 and "--set and --slide need a model" in said
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    monkeypatch.delitem(sys.modules, "vfife.live.server.app")
    code, said = told(folder / "bar.toml", "--no-browser")
    assert code == 2 and "vfife[live]" in said and "-o PAGE.html" in said


def test_progress_of_a_run_is_told_line_by_line_and_left_out_of_its_answer(folder, monkeypatch):
    """A program in place of the command line waits between its lines until the line before was reported."""
    program = """
import pathlib, sys, time
print("the answer", flush=True)
for share in (" 58", "100"):
    print(f"{share} %  1,000 of 2,000 steps  0.2 s left", file=sys.stderr, flush=True)
    while not pathlib.Path(share.strip()).exists():
        time.sleep(0.01)
print("its end", flush=True)
"""
    monkeypatch.setattr("vfife.live.server.session.COMMAND", program)
    events: list[dict] = []
    ended = threading.Event()

    def notify(event: dict) -> None:
        events.append(event)
        if event["kind"] == "progress":
            (folder / event["said"].partition(" ")[0]).touch()
        else:
            ended.set()

    runs = Runs(notify, folder, [])
    runs.begin(Session(folder, sliders=False).shelf.from_text("any", TEXT))
    assert ended.wait(30.0)
    assert [event["kind"] for event in events] == ["progress", "progress", "run"]
    assert events[0]["said"].startswith("58 %") and events[1]["said"].startswith("100 %")
    assert events[2]["code"] == 0 and events[2]["said"] == "the answer\nits end"
