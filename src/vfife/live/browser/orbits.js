// Journals in their clearance circles, coloured by joint force; blocks in their guides with enlarged clearance.

// Joints with contacts, each with the indices of its contacts; a block in a guide has four.
const loose = [];
given.contacts.forEach(({ joint, kind }, place) => {
  const known = loose.find((contact) => contact.joint === joint);
  if (known) known.places.push(place);
  else loose.push({ joint, kind, places: [place] });
});

function drawOrbits(pen, width, height, running, head, comparison) {
  const room = (columns) => Math.min(width / columns, height / Math.ceil(loose.length / columns) - 20);
  const columns = loose.map((_, k) => k + 1).reduce((best, count) => (room(count) > room(best) ? count : best));
  const rows = Math.ceil(loose.length / columns);
  const [w, h] = [width / columns, height / rows];
  pen.font = `600 12px ${FONT}`;
  const titles = loose.map(({ joint, places: [k] }) => [joint, running.reader.plays[k] ? `±${quantity(running.reader.plays[k], "m")}` : ""]);
  const broken = titles.some((words) => pen.measureText(words.join("  ")).width > w - 10); // two lines then, so that neighbours stay apart
  loose.forEach((contact, k) => {
    const middle = [(k % columns) * w + w / 2, Math.floor(k / columns) * h + h / 2 + 4];
    const radius = 0.5 * Math.min(w, h - 28 * broken) - 24;
    if (radius < 12) return;
    pen.fillStyle = ink.ink;
    pen.font = `600 12px ${FONT}`;
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    const lines = broken ? titles[k] : [titles[k].filter(Boolean).join("  ")];
    const lowest = middle[1] - radius - 12;
    for (const [line, text] of lines.entries()) pen.fillText(text, middle[0], lowest - 14 * (lines.length - 1 - line), w - 6);
    if (contact.kind === "bearing") orbit(pen, middle, radius, contact, running, head, comparison);
    else if (contact.places.length > 1) block(pen, middle, radius, contact, running, head);
    else gap(pen, middle, radius, contact, running, head);
  });
}

function orbit(pen, middle, radius, { joint, places: [k] }, running, head, comparison) {
  const { reader, store } = running;
  const points = path(running, head, k);
  const ghosts = comparison?.store.end ? path(comparison, head, k) : [];
  const furthest = [...points, ...ghosts].reduce((most, [x, y]) => Math.max(most, Math.hypot(x, y)), 0);
  const scale = radius / Math.max(reader.plays[k], comparison?.reader.plays[k] ?? 0, furthest); // penetrations may be as large as the clearance
  disc(pen, middle, scale * reader.plays[k], ink.grey, ink.card, 1.2);
  pen.strokeStyle = ink.faint;
  pen.lineWidth = 0.8;
  segment(pen, [middle[0] - radius, middle[1]], [middle[0] + radius, middle[1]]);
  segment(pen, [middle[0], middle[1] - radius], [middle[0], middle[1] + radius]);
  const at = ([x, y]) => [middle[0] + scale * x, middle[1] - scale * y];
  if (ghosts.length) {
    pen.strokeStyle = ink.other;
    pen.lineWidth = 1.1;
    pen.setLineDash([3, 2]);
    trail(pen, ghosts.map(at));
    pen.stroke();
    pen.setLineDash([]);
  }
  const largest = Math.max(...running.turns.shown.map((turn) => turn.force[joint] ?? 0), 1e-300);
  // Segments are drawn by colour, in few paths, because a canvas is slow with many short paths.
  const shades = 6;
  for (let shade = 0; shade < shades; shade++) {
    pen.beginPath();
    let visible = false;
    for (let n = 1; n < points.length; n++) {
      const share = Math.min(Math.sqrt(points[n][2] / largest), 0.999);
      if (Math.floor(share * shades) !== shade) continue;
      pen.moveTo(...at(points[n - 1]));
      pen.lineTo(...at(points[n]));
      visible = true;
    }
    if (!visible) continue;
    pen.strokeStyle = heat((shade + 0.5) / shades);
    pen.lineWidth = 1 + 0.5 * shade;
    pen.stroke();
  }
  pen.fillStyle = ink.grey;
  pen.font = `11px ${FONT}`;
  pen.fillText(`up to ${quantity(largest, "N")}`, middle[0], middle[1] + radius + 11);
  const pose = Pose.at(running, head);
  const journal = at(reader.eccentricity(store.data, pose.from, k));
  disc(pen, journal, 4.5, ink.ink, ink.warm, 1.4);
}

// First and last output of the turn before the head, or of the whole run.
function turnBefore(store, head) {
  const last = Math.min(Math.floor(head), store.end - 1);
  return [Math.max(store.begin, last - (perTurn ?? wholeRun)), last];
}

// Positions of a journal in its bearing over the last turn, with the contact force at each.
function path({ reader, store }, head, k) {
  const [first, last] = turnBefore(store, head);
  const stride = Math.max(1, Math.ceil((last - first) / 720));
  const [normal, friction] = [reader.of("contact_normal_force")[k], reader.of("contact_friction_force")[k]];
  const found = [];
  for (let n = first; n <= last; n += stride) {
    const at = store.offset(n);
    const [x, y] = reader.eccentricity(store.data, at, k);
    found.push([x, y, Math.hypot(store.data[at + normal], store.data[at + friction])]);
  }
  return found;
}

// A block between the walls of its guide, with the gap at each corner enlarged to fill the panel.
function block(pen, middle, radius, { places }, running, head) {
  const { reader } = running;
  const pose = Pose.at(running, head);
  const play = reader.plays[places[0]];
  const depth = places.map((k) => pose.data[pose.from + reader.of("contact_penetration")[k]]); // rear and front at the left wall, then at the right wall
  const [wide, wall, tall] = [0.95 * radius, 0.8 * radius, 0.3 * radius];
  const reach = wall - tall; // clearance on each side, as drawn
  const gaps = depth.map((value) => (Math.max(-value, 0) / play) * reach);
  const strip = [
    [-1, 1],
    [1, 1],
    [1, 1.18],
    [-1, 1.18],
  ];
  for (const side of [-1, 1])
    hatched(
      pen,
      strip.map(([x, y]) => [middle[0] + wide * x, middle[1] + side * wall * y]),
    );
  const [w, corners] = [0.7 * wide, [gaps[0], gaps[1], gaps[3], gaps[2]]];
  const points = [
    [-w, -wall + corners[0]],
    [w, -wall + corners[1]],
    [w, wall - corners[2]],
    [-w, wall - corners[3]],
  ];
  trail(
    pen,
    points.map(([x, y]) => [middle[0] + x, middle[1] + y]),
    true,
  );
  pen.fillStyle = ink.accent;
  pen.globalAlpha = 0.25;
  pen.fill();
  pen.globalAlpha = 1;
  pen.strokeStyle = ink.accent;
  pen.lineWidth = 1.8;
  pen.stroke();
  const order = [0, 1, 3, 2];
  points.forEach(([x, y], i) => {
    const pressed = depth[order[i]] > 0;
    if (pressed) disc(pen, [middle[0] + x, middle[1] + y], 5, ink.ink, ink.warm);
  });
}

// Gap or penetration of any other contact over the last turn.
function gap(pen, middle, radius, { places: [k] }, running, head) {
  const { reader, store } = running;
  const [first, last] = turnBefore(store, head);
  const column = reader.of("contact_penetration")[k];
  const values = [];
  for (let n = first; n <= last; n++) values.push(-store.data[store.offset(n) + column]);
  const largest = values.reduce((most, value) => Math.max(most, Math.abs(value)), 1e-12);
  const low = [middle[0] - radius, middle[1] + 0.6 * radius];
  hatched(pen, [low, [middle[0] + radius, low[1]], [middle[0] + radius, low[1] + 8], [low[0], low[1] + 8]]);
  trail(
    pen,
    values.map((value, n) => [low[0] + (2 * radius * n) / Math.max(values.length - 1, 1), low[1] - (1.3 * radius * value) / largest]),
  );
  pen.strokeStyle = ink.accent;
  pen.lineWidth = 1.6;
  pen.stroke();
  pen.fillStyle = ink.grey;
  pen.font = `11px ${FONT}`;
  pen.fillText(`gap ${quantity(values.at(-1) ?? 0, "m")}, of ${quantity(largest, "m")}`, middle[0], low[1] + 20);
}
