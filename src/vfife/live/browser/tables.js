// Table of peaks in the last turn, with their range over the turns shown and the increase over the ideal mechanism.

// Range of values with as many digits, three or four, as its ends need to differ; one number where four digits are alike.
// `write` gives the text of a value with a number of digits.
const endsText = (low, high, write) => {
  const pairs = [3, 4].map((digits) => [write(low, digits), write(high, digits)]);
  const [first, last] = pairs.find((pair) => pair[0] !== pair[1]) ?? pairs[1];
  return first === last ? last : `${first} … ${last}`;
};

const rangeText = (values, unit) => {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  if (values.length < 2 || low === high) return "";
  const size = Math.max(Math.abs(low), Math.abs(high)); // one unit for both ends
  const name = quantity(high, unit, 3, size).split(" ").slice(1).join(" ");
  return `${endsText(low, high, (value, digits) => quantity(value, unit, digits, size).split(" ")[0])} ${name}`.trim();
};

const percent = (value, digits = 3) =>
  Number.isFinite(value) ? `${value > 0 ? "+" : value < 0 ? "−" : ""}${Number(Math.abs(value).toPrecision(digits))} %` : "–";

// Rows of the table: quantity, name, unit, values by turn, and the value of the ideal mechanism.
function peaks(running) {
  const turns = running.turns.shown;
  const found = [];
  for (const name of Object.keys(own.joints)) {
    found.push({
      what: "force",
      name,
      unit: "N",
      joint: name,
      values: turns.map((turn) => turn.force[name]),
      ideal: running.ideally("force", name),
    });
  }
  for (const name of Object.keys(own.torques)) {
    const values = turns.map((turn) => turn.torque[name]);
    found.push({ what: "torque", name, unit: "N m", joint: TORQUE + name, values, ideal: running.ideally("torque", name) });
  }
  const fastest = Math.max(...turns.flatMap((turn) => Object.values(turn.alpha)), 0);
  for (const body of turning) {
    const values = turns.map((turn) => turn.alpha[body.name]);
    if (Math.max(...values) <= 1e-9 * fastest) continue; // rounding errors of a body that does not turn
    found.push({ what: "angular acceleration", name: body.name, unit: "rad/s²", values, ideal: running.ideally("alpha", body.name) });
  }
  given.contacts.forEach((contact, k) => {
    found.push({ what: "depth", name: contact.name, unit: "m", joint: contact.joint, values: turns.map((turn) => turn.depth[k]) });
    if (!factors)
      found.push({ what: "contacts begun", name: contact.name, unit: "1", joint: contact.joint, values: turns.map((turn) => turn.began[k]) });
  });
  return found.filter(({ values }) => values.length);
}

const cell = (text, kind = "td") => {
  const made = document.createElement(kind);
  made.textContent = text;
  return made;
};

function writePeaks(table, running, comparison) {
  const rows = peaks(running);
  const kept = comparison ? peaks(comparison) : [];
  const compared = rows.some((row) => row.ideal);
  const head = ["largest", perTurn ? "last turn" : factors ? "along the load path" : "so far"];
  if (perTurn) head.push(running.turns.words);
  if (compared) head.push("ideal", "clearance adds", perTurn ? "over the turns" : "");
  if (comparison) head.push("kept setting");
  const top = document.createElement("tr");
  top.append(...head.map((text) => cell(text, "th")));
  const body = rows.map((row) => {
    const line = document.createElement("tr");
    const last = row.values.at(-1);
    const cells = [`${row.what} ${row.name}`, quantity(last, row.unit)];
    if (perTurn) cells.push(rangeText(row.values, row.unit));
    if (compared) {
      const lips = row.values.map((value) => (100 * (value - row.ideal)) / row.ideal);
      cells.push(row.ideal ? quantity(row.ideal, row.unit) : "", row.ideal ? percent(lips.at(-1)) : "");
      cells.push(row.ideal && lips.length > 1 ? endsText(Math.min(...lips), Math.max(...lips), percent) : "");
    }
    if (comparison) cells.push(quantity(kept.find((peak) => peak.what === row.what && peak.name === row.name)?.values.at(-1), row.unit));
    line.append(...cells.map((text, k) => cell(text, k ? "td" : "th")));
    if (row.joint && row.joint === selected.joint) line.className = "chosen";
    return line;
  });
  table.tHead.replaceChildren(top);
  table.tBodies[0].replaceChildren(...body);
}

// Energy balance at a moment: energy stored, lost and supplied since the start, and the remainder, which is numerical error.
function ledgerText(running, head) {
  const pose = Pose.at(running, head);
  if (!pose || !running.reader.first) return "";
  const { reader } = running;
  const start = reader.ledger(reader.first, 0, true);
  const current = reader.ledger(pose.data, pose.from, Math.floor(head) === 0);
  const left = summed(current, STORED) + summed(current, LOST) - summed(current, SUPPLIED) - summed(start, STORED);
  const largest = Math.max(...Object.values(current).map(Math.abs), summed(start, STORED), 1e-300);
  const parts = Object.entries(current).filter(([, value]) => Math.abs(value) > 1e-9 * largest);
  const words = parts.map(([name, value]) => `${name} ${quantity(value, "J")}`).join(", ");
  return `Since the start: ${words}. Left over: ${quantity(left, "J")}, ${((100 * Math.abs(left)) / largest).toExponential(1)} % of the largest.`;
}
