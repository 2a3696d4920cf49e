"""Noise of a run: its hardest knock, the joints that may have it, and blows in closed contact."""

from __future__ import annotations

from collections.abc import Iterator

from ..measures.values import NOT_ESTIMATED
from .design_words import and_words
from .digits import CERTAIN, SCATTER, Json, is_about_zero, is_estimated, largest_text, sum_text
from .run_tables import NONE_BEGAN, blow_texts, knock_texts, knocks, may_not_knock, of_contacts, own_knocks

STEPS_ONLY = "at other step sizes only"  # a joint knocks, but not in this run
# Share of the rise of a joint's largest force above the ideal one: a larger blow makes this force, or is
# hidden behind it.
HALF = 0.5


def noise(summary: Json) -> Iterator[tuple[str, str]]:
    """Yield the hardest knock and the power of all knocks."""
    speeds = {
        name: value for name, value in summary["measures"].items() if name.endswith(".approach_speed.max")
    }
    if not speeds:
        return
    hardest = max(speeds, key=speeds.__getitem__)
    if not speeds[hardest] or is_about_zero(summary, hardest):
        yield "Noise", "no knocks"
        return
    names = [name for name in summary["measures"] if name.endswith(".impact_power.mean")]
    losses = f"; knocks lose {sum_text(summary, names, 'W', SCATTER)}" if names else ""
    harder = rivals(summary, hardest, list(speeds))
    speed, joint = largest_text(summary, harder, "m/s", CERTAIN), _contact_words(harder)
    measured = summary.get("knocks", {})
    whole = f"in the whole run {speed} ({joint})"
    if not measured or any(entry["hardest"] and entry["count"] for entry in measured.values()):
        place = f"{joint}, whole run{_silent_words(summary, harder)}"
        yield "Noise", f"hardest knock {speed} ({place}){_measured_knock(summary)}{losses}"
    elif not any(entry["count"] for entry in measured.values()):
        yield "Noise", f"no knocks in the turns of the table; {whole}"
    else:
        contact = max(measured, key=lambda name: float(measured[name]["speed"]))
        text = knock_texts(summary, contact.split(".")[0])[0]
        largest = _with_joint(text, _contact_words([contact]))
        silent = may_not_knock(summary, contact.split(".")[0])
        doubt = "; at other step sizes it may not knock at all" if silent else ""
        yield "Noise", f"hardest knock {largest}, {whole}{doubt}{losses}"


def _silent_words(summary: Json, names: list[str]) -> str:
    """Return which joints of the measures ``names`` have no knock in the table of joints, and where they
    have one; "" for none.
    """
    silent: dict[str, list[str]] = {}
    for joint in dict.fromkeys(name.split(".")[0] for name in names):
        if knock_texts(summary, joint)[0] in ("none", NONE_BEGAN):
            count = knocks(summary, joint)[0]
            silent.setdefault("not in the turns of the table" if count else STEPS_ONLY, []).append(joint)
    return "".join(f"; {and_words(joints)} {words}" for words, joints in silent.items())


def blow(summary: Json) -> Iterator[tuple[str, str]]:
    """Yield the largest blow in closed contact that is not small beside the knocks of its joint: there are
    none in the turns of the measures, or they raise the force by less than twice as much.
    """
    if (summary["turns"] or {}).get("peaks_only") and any(
        knock_texts(summary, joint)[0] in ("none", NONE_BEGAN) for joint in summary["joints"]
    ):
        yield "Blow", f"not determined, because the step does not divide a turn ({NOT_ESTIMATED})"
        return
    for name, text in blow_texts(summary).items():
        joint = summary["joints"][name]
        rise = joint["force.max"] - (joint["ideal_force.max"] or 0.0)
        quiet = knock_texts(summary, name)[0] in ("none", NONE_BEGAN)
        if quiet or summary["blows"][name]["excess"] > HALF * rise:
            yield "Blow", f"{text} (no knock; {NOT_ESTIMATED})"
            return


def _measured_knock(summary: Json) -> str:
    """Return the hardest knock of the turns of the measures, as the table of joints has it, where the whole
    run has harder ones.
    """
    texts = {name: knock_texts(summary, name) for name in summary["joints"]}
    if not summary.get("knocks") or not any(whole for _, whole in texts.values()):
        return ""
    hardest = " or ".join(_with_joint(texts[joint][0], joint) for joint in hardest_joints(summary))
    return f", {hardest} in the turns of the table"


def hardest_joints(summary: Json) -> list[str]:
    """Return the joints of which any may knock hardest in the turns of the measures: that of the hardest
    knock, then those whose ranges reach the largest lower end. A speed without a range stands for itself.
    """
    names = [name for name in summary["joints"] if of_contacts(summary, name, "approach_speed.max")]
    speeds = {name: knock_speed(summary, name) for name in names}
    ends = {name: _knock_ends(summary, name) for name in names}
    lowest = max((low for low, _ in ends.values()), default=0.0)
    ordered = sorted(names, key=lambda name: -speeds[name])
    return [name for k, name in enumerate(ordered) if k == 0 or ends[name][1] > lowest]


def knock_speed(summary: Json, joint: str) -> float:
    """Return the speed (m/s) of the hardest knock of a joint in the turns of the measures."""
    speeds = [float(entry["speed"]) for entry in own_knocks(summary, joint)]
    names = of_contacts(summary, joint, "approach_speed.max")
    return max(speeds or [float(summary["measures"][name]) for name in names], default=0.0)


def _knock_ends(summary: Json, joint: str) -> tuple[float, float]:
    """Return the range (m/s) of the hardest knock of a joint in the turns of the measures: that of the whole
    run if it is in these turns, else the speed at both ends.
    """
    measured, speed = own_knocks(summary, joint), knock_speed(summary, joint)
    names = of_contacts(summary, joint, "approach_speed.max")
    in_turns = not measured or any(entry["hardest"] and entry["count"] for entry in measured)
    if not in_turns or not all(is_estimated(summary, name) for name in names):
        return speed, speed
    ranges = [summary["ranges"][name] for name in names]
    return max(float(ends["low"]) for ends in ranges), max(float(ends["high"]) for ends in ranges)


def _with_joint(knock: str, joint: str) -> str:
    """Return the text of a knock with its joint, in one pair of brackets with the note on its error."""
    mark = f" ({NOT_ESTIMATED})"
    inside = f"{joint}, {NOT_ESTIMATED}" if knock.endswith(mark) else joint
    return f"{knock.removesuffix(mark)} ({inside})"


def rivals(summary: Json, hardest: str, names: list[str]) -> list[str]:
    """Return the measures of which any may be the largest: their ranges reach that of the ``hardest``."""
    if not all(is_estimated(summary, name) for name in names):
        return [hardest]
    lowest = max(float(summary["ranges"][name]["low"]) for name in names)
    return [name for name in names if name == hardest or summary["ranges"][name]["high"] > lowest]


def _contact_words(names: list[str]) -> str:
    """Return the joints of contacts or of their measures; of a single corner of a block also the corner."""
    contacts = [name.removesuffix(".approach_speed.max").split(".") for name in names]
    joints = list(dict.fromkeys(contact[0] for contact in contacts))
    corner = f", corner {contacts[0][1]}" if len(contacts) == 1 and len(contacts[0]) > 1 else ""
    return " or ".join(joints) + corner
