// Load path of a static analysis: load factors instead of time, and the displacements under them.

const { factors } = given; // undefined for a dynamic run

// The load factor between two equilibria.
function factorAt(head) {
  const low = Math.min(Math.max(Math.floor(head), 0), factors.length - 1);
  const high = Math.min(low + 1, factors.length - 1);
  return factors[low] + Math.min(Math.max(head - low, 0), 1) * (factors[high] - factors[low]);
}

const rising = factors?.every((factor, k) => k === 0 || factor > factors[k - 1]);

// Axis of load factors if they increase, else of the numbers of equilibria.
function axisOfPath() {
  if (!rising) return { low: 0, high: wholeRun, label: "equilibrium", of: (k) => k };
  return { low: factors[0], high: factors.at(-1), label: "load factor", of: factorAt };
}

// Body and axis with the largest displacement.
function longestWay({ reader, store }) {
  const found = { way: -1, body: selected.body, quantity: "x" };
  for (const body of given.bodies) {
    const places = factors.map((_, k) => reader.point(store.data, store.offset(k), body.centre));
    ["x", "y"].forEach((quantity, axis) => {
      const way = Math.max(...places.map((place) => Math.abs(place[axis] - places[0][axis])));
      if (way > found.way) Object.assign(found, { way, body: body.name, quantity });
    });
  }
  return found;
}

// Coordinate or angle of the selected body.
function wayOf({ reader, store }, at) {
  const body = given.bodies.find((candidate) => candidate.name === selected.body);
  if (selected.quantity === "angle") return reader.turn(store.data, at, body)[0];
  const [x, y] = reader.point(store.data, at, body.centre);
  return selected.quantity === "x" ? x : y;
}

function drawPath(pen, width, height, running, head) {
  const { store } = running;
  if (store.end < 2) return waiting(pen, width, height);
  const ways = factors.map((_, k) => wayOf(running, store.offset(k)));
  if (selected.quantity === "angle") {
    for (let k = 1; k < ways.length; k++) ways[k] -= 2 * Math.PI * Math.round((ways[k] - ways[k - 1]) / (2 * Math.PI));
  }
  const moved = ways.map((way) => way - ways[0]);
  const [unit, name] = QUANTITIES[selected.quantity];
  const [factor, shown] = unit === "rad" ? [180 / Math.PI, "°"] : scaleOf(largestOf([moved.map(Math.abs)]), unit);
  const [low, high] = [Math.min(...moved), Math.max(...moved)].map((value) => factor * value);
  const room = Math.max(0.04 * (high - low), factor * 1e-9 * (unit === "rad" ? 1 : scene.size)); // smaller ranges are rounding errors
  const loads = { low: Math.min(...factors), high: Math.max(...factors), label: "load factor" };
  const axes = new Axes(pen, width, height, { low: low - room, high: high + room, label: `change of ${name} (${shown})` }, loads);
  const scaled = moved.map((value) => factor * value);
  axes.line(scaled, factors, { colour: ink.accent });
  factors.forEach((loadFactor, k) => {
    axes.dot(scaled[k], loadFactor, ink.accent);
  });
  const k = Math.min(Math.floor(head), factors.length - 2);
  axes.dot(scaled[k] + (head - k) * (scaled[k + 1] - scaled[k]), factorAt(head), ink.warm);
}
