// Charts of the turns shown: forces with the ideal mechanism, phase portrait, spectrum, energies.

// First output and number of outputs of each complete turn in the buffer; without a crank of the run so far.
function turnsOf(running) {
  const { store } = running;
  if (!perTurn) return store.end > 1 ? [{ first: 0, count: store.end - 1 }] : [];
  return running.turns.shown
    .filter((turn) => turn.first >= store.begin && turn.last - turn.first === perTurn)
    .map(({ first }) => ({ first, count: perTurn }));
}

// The turn at the moment in view, or the one before it, if complete in the buffer; else the last complete turn.
function turnAt(running, head) {
  const { store } = running;
  if (!perTurn) return turnsOf(running)[0];
  const first = perTurn * Math.floor(Math.min(head, store.end - 1) / perTurn);
  const whole = [first, first - perTurn].find((begin) => begin >= store.begin && begin + perTurn < store.end);
  return whole === undefined ? turnsOf(running).at(-1) : { first: whole, count: perTurn };
}

const CRANK_ANGLE = "crank angle (degrees)"; // as in vfife.plots.turn

// Horizontal axis and the map from outputs to it: crank angle (degrees), load factor or time.
function axisOf(running) {
  if (perTurn) {
    const of = (k) => running.reader.rotation(k / perTurn);
    const label = given.crank === "crank" ? CRANK_ANGLE : `${CRANK_ANGLE}, body ${given.crank}`;
    return { low: 0, high: 360, label, angle: true, of };
  }
  if (factors) return axisOfPath();
  const end = wholeRun * running.reader.interval;
  const [factor, unit] = scaleOf(end, "s");
  return { low: 0, high: factor * end, label: `time (${unit})`, of: (k) => factor * k * running.reader.interval };
}

const largestOf = (lists) => lists.reduce((overall, list) => list.reduce((largest, value) => (value > largest ? value : largest), overall), 0);

// Cache of series by turn: charts are redrawn several times a second, and complete turns do not change.
const known = new Map();

function remembered(key, make) {
  if (!known.has(key)) {
    if (known.size > 150) known.clear();
    known.set(key, make());
  }
  return known.get(key);
}

let numbered = 0;
const names = new WeakMap();

// Cache key of a turn. It contains the number of outputs, so that a turn in progress is computed again when it has grown.
function keyOf(store, { first, count }, ...more) {
  if (!names.has(store)) names.set(store, ++numbered);
  return [names.get(store), first, count, ...more].join(" ");
}

// Largest force in each interval between outputs of a turn.
function forcesOf(reader, store, turn, name) {
  return remembered(keyOf(store, turn, "force", name), () => foundForces(reader, store, turn, name));
}

function foundForces(reader, store, { first, count }, name) {
  return Float64Array.from({ length: count + 1 }, (_, k) =>
    reader.forceMax(store.data, store.offset(first + Math.max(k, first || factors ? 0 : 1)), name),
  );
}

const unitOf = (name) => (name.startsWith(TORQUE) ? "N m" : "N");

function drawForces(pen, width, height, running, head, comparison) {
  const turn = turnAt(running, head);
  if (!turn) return waiting(pen, width, height);
  const x = axisOf(running);
  const xs = Array.from({ length: turn.count + 1 }, (_, k) => x.of(k));
  const current = forcesOf(running.reader, running.store, turn, selected.joint);
  const turns = turnsOf(running).map((complete) => forcesOf(running.reader, running.store, complete, selected.joint));
  const compared =
    comparison && turnAt(comparison, head) ? forcesOf(comparison.reader, comparison.store, turnAt(comparison, head), selected.joint) : null;
  const idealCurve = idealForces(running);
  const largest = largestOf([current, ...turns, ...(compared ? [compared] : []), ...(idealCurve ? [idealCurve.ys] : [])]);
  const [factor, unit] = scaleOf(largest, unitOf(selected.joint));
  const scaled = (list) => Array.from(list, (value) => factor * value);
  const legend = [["this setting", ink.accent]];
  if (turns.length > 1) legend.push([`range over ${running.turns.words}`, ink.accent, [], 7]);
  if (idealCurve) legend.push(["ideal", ink.ideal, [8, 4]]);
  if (compared) legend.push(["kept setting", ink.other, [3, 2]]);
  const axes = new Axes(
    pen,
    width,
    height,
    x,
    { low: 0, high: factor * largest || 1, label: `${selected.joint.startsWith(TORQUE) ? "torque" : "force"} (${unit})` },
    legend,
  );
  if (turns.length > 1) {
    const lows = xs.map((_, k) => factor * Math.min(...turns.map((series) => series[k])));
    const highs = xs.map((_, k) => factor * Math.max(...turns.map((series) => series[k])));
    axes.band(xs, lows, highs, ink.accent);
  }
  if (compared) axes.line(xs, scaled(compared), { colour: ink.other, width: 1.5, dash: [3, 2] });
  axes.line(xs, scaled(current), { colour: ink.accent });
  if (idealCurve) axes.line(idealCurve.xs, scaled(idealCurve.ys), { colour: ink.ideal, width: 2.2, dash: [8, 4] });
  return axes.follow(x, head);
}

// Forces of the selected joint in the ideal turn, over the crank angle, since its steps differ from those of the mechanism.
function idealForces({ idealReader, idealStore }) {
  if (!idealStore || idealStore.end <= ideal.perTurn || !(selected.joint in ideal.joints || selected.joint.startsWith(TORQUE))) return null;
  const ys = forcesOf(idealReader, idealStore, { first: 0, count: ideal.perTurn }, selected.joint);
  return { xs: Array.from(ys, (_, k) => idealReader.rotation(k / ideal.perTurn)), ys };
}

// ---------------------------------------------------------------------------------------------------------------- phase

// What may be shown in phase: angle of each body, and how its centre moves along x and y.
const QUANTITIES = { angle: ["rad", "angle"], x: ["m", "x"], y: ["m", "y"] };

function phaseOf(running, turn) {
  const key = keyOf(running.store, turn, "phase", selected.body, selected.quantity);
  return remembered(key, () => foundPhase(running, turn));
}

function foundPhase({ reader, store }, { first, count }) {
  const body = given.bodies.find((candidate) => candidate.name === selected.body);
  const found = { xs: [], ys: [] };
  found.points = [found.xs, found.ys]; // an entry for each output
  let [last, whole] = [null, 0];
  for (let k = first; k <= first + count; k++) {
    const at = store.offset(k);
    let pair = null;
    if (selected.quantity === "angle") {
      pair = reader.turn(store.data, at, body);
      if (last !== null) whole -= Math.round((pair[0] + whole - last) / (2 * Math.PI)) * 2 * Math.PI;
      last = pair[0] + whole;
      pair = [last, pair[1]];
    } else {
      const [x, y, vx, vy] = reader.point(store.data, at, body.centre);
      pair = selected.quantity === "x" ? [x, vx] : [y, vy];
    }
    found.xs.push(pair[0]);
    found.ys.push(pair[1]);
  }
  const [low, high] = [Math.min(...found.xs), Math.max(...found.xs)];
  if (selected.quantity !== "angle" || high - low <= 6) return found;
  const [xs, ys] = overTurn(
    found.xs.map((value) => (180 / Math.PI) * value),
    found.ys,
  ); // it turns round
  return { ...found, xs: xs.map((value) => (Math.PI / 180) * value), ys, around: true };
}

function drawPhase(pen, width, height, running, head, comparison) {
  const turn = turnAt(running, head);
  if (!turn) return waiting(pen, width, height);
  const portraits = turnsOf(running).map((complete) => phaseOf(running, complete));
  const current = phaseOf(running, turn);
  const compared = comparison && turnAt(comparison, head) ? phaseOf(comparison, turnAt(comparison, head)) : null;
  const lists = [...portraits, current, ...(compared ? [compared] : [])];
  const [unit, name] = QUANTITIES[selected.quantity];
  const size = (key) => largestOf(lists.map((portrait) => portrait[key].map(Math.abs)));
  const [fx, ux] = unit === "rad" ? [180 / Math.PI, "°"] : scaleOf(size("xs"), unit);
  const [fy, uy] = unit === "rad" ? [1, "rad/s"] : [scaleOf(size("ys"), unit)[0], `${scaleOf(size("ys"), unit)[1]}/s`];
  const range = (key, factor) => {
    const values = lists.flatMap((portrait) => portrait[key]).filter(Number.isFinite);
    const [low, high] = [values.reduce((a, b) => Math.min(a, b)), values.reduce((a, b) => Math.max(a, b))];
    const smallest = 1e-9 * (unit === "rad" ? 1 : scene.size) * (key === "ys" ? 1 / running.reader.interval : 1); // smaller ranges are rounding errors
    const room = Math.max(0.02 * (high - low), high - low < smallest ? smallest : 0);
    return { low: factor * (low - room), high: factor * (high + room) };
  };
  const axes = new Axes(
    pen,
    width,
    height,
    { ...range("xs", fx), label: `${name} (${ux})` },
    { ...range("ys", fy), label: `its rate (${uy})`, exact: true },
  );
  const scaled = ({ xs, ys }) => [xs.map((value) => fx * value), ys.map((value) => fy * value)];
  for (const portrait of portraits) axes.line(...scaled(portrait), { colour: ink.accent, width: 1, alpha: 0.3 });
  if (compared) axes.line(...scaled(compared), { colour: ink.other, width: 1.3, dash: [3, 2] });
  axes.line(...scaled(current), { colour: ink.accent });
  const k = Math.round(head - turn.first);
  if (k < 0 || k > turn.count) return;
  const [x, y] = current.points.map((list) => list[k]);
  axes.dot(current.around ? withinTurn(fx * x) : fx * x, fy * y, ink.warm);
}

// ------------------------------------------------------------------------------------------------------------- spectrum

// Amplitudes at whole numbers of waves in a series, with a Hann window for a series that is not periodic. A direct sum:
// its length is any number of outputs per turn, and one turn at a time is fast enough.
function amplitudes(values, window) {
  const count = values.length;
  const highest = Math.min(Math.floor(count / 2), 1400);
  const cosines = Float64Array.from({ length: count }, (_, k) => Math.cos((2 * Math.PI * k) / count));
  const weighed = window ? values.map((value, k) => value * (1 - cosines[k])) : values;
  return Float64Array.from({ length: highest }, (_, order) => {
    let [re, im] = [0, 0];
    for (let k = 0, at = 0; k < count; k++) {
      re += weighed[k] * cosines[at];
      im += weighed[k] * cosines[(at + 3 * (count >> 2)) % count]; // the sine; count is a multiple of 4, see seriesOf
      at += order;
      if (at >= count) at -= count;
    }
    return ((order ? 2 : 1) * Math.hypot(re, im)) / count;
  });
}

function seriesOf({ reader, store }, { first, count }) {
  const four = count - (count % 4);
  return Float64Array.from({ length: four }, (_, k) => reader.size(store.data, store.offset(first + 1 + k), selected.joint));
}

const spectra = new Map(); // last spectrum of each run, with the turns that it was computed from

// Orders of the crank (or frequencies, Hz) and amplitudes: root mean square over the last four turns.
function spectrumOf(running) {
  const turns = turnsOf(running).slice(-4);
  if (!turns.length || (!perTurn && turns[0].count < 16)) return null;
  const key = `${running.id} ${turns[0].first} ${turns.at(-1).first + turns.at(-1).count} ${selected.joint}`;
  if (spectra.get(running)?.key !== key) {
    const spectraOfTurns = turns.map((turn) => amplitudes(seriesOf(running, turn), !perTurn));
    const ys = spectraOfTurns[0].map((_, k) =>
      Math.sqrt(spectraOfTurns.reduce((sum, spectrum) => sum + spectrum[k] ** 2, 0) / spectraOfTurns.length),
    );
    const span = perTurn ? 1 : turns[0].count * running.reader.interval;
    spectra.set(running, { key, xs: Array.from(ys, (_, k) => k / span), ys });
  }
  return spectra.get(running);
}

// Upper end of the axis of a spectrum: 10 % beyond the last amplitude above `floor`.
function reached({ xs, ys }, floor) {
  const last = ys.reduce((most, value, k) => (value > floor ? k : most), 12);
  return xs[Math.min(Math.ceil(1.1 * last), xs.length - 1)];
}

function drawSpectrum(pen, width, height, running, _head, comparison) {
  const spectrum = spectrumOf(running);
  if (!spectrum) return waiting(pen, width, height);
  const compared = comparison && spectrumOf(comparison);
  const largest = Math.max(largestOf([spectrum.ys, ...(compared ? [compared.ys] : [])]), 1e-12);
  const top = 10 ** Math.ceil(Math.log10(largest) + 0.05);
  const label = perTurn ? "order of the crank" : "frequency (Hz)";
  const axes = new Axes(
    pen,
    width,
    height,
    { low: 0, high: reached(spectrum, top * 1e-6), label },
    { low: top * 1e-6, high: top, label: `amplitude (${unitOf(selected.joint)})`, log: true },
  );
  if (compared) axes.line(compared.xs, compared.ys, { colour: ink.other, width: 1, dash: [3, 2] });
  axes.line(spectrum.xs, spectrum.ys, { colour: ink.accent, width: 1.2 });
}

// --------------------------------------------------------------------------------------------------------------- energy

const LEDGER = [
  ["kinetic", ["kinetic"]],
  ["elastic", ["strain", "contact", "spring"]],
  ["lost", LOST],
  ["supplied", SUPPLIED],
];

function energiesOf(running, turn) {
  return remembered(keyOf(running.store, turn, "energy"), () => foundEnergies(running, turn));
}

function foundEnergies(running, turn) {
  const { reader, store } = running;
  const stride = Math.max(1, Math.floor(turn.count / 180));
  const found = [];
  for (let k = 0; k <= turn.count; k += stride)
    found.push({ k, terms: reader.ledger(store.data, store.offset(turn.first + k), turn.first + k === 0) });
  return found;
}

function drawEnergy(pen, width, height, running, head) {
  const turn = turnAt(running, head);
  if (!turn) return waiting(pen, width, height);
  const x = axisOf(running);
  const found = energiesOf(running, turn);
  const xs = found.map(({ k }) => x.of(k));
  const start = found[0].terms;
  // All count from the beginning of the turn: the energy that is stored in a flywheel would press works onto the axis.
  const lines = LEDGER.map(([name, terms]) => [name, found.map((sample) => summed(sample.terms, terms) - summed(start, terms))]);
  const terms = lines.flatMap(([, values]) => values);
  const [low, high] = [Math.min(0, ...terms), Math.max(0, ...terms)];
  const [factor, unit] = scaleOf(Math.max(high, -low), "J");
  const legend = lines.map(([name], k) => [name, ink.bodies[k], DASHES[k]]);
  const label = `energy since the ${perTurn ? "turn began" : "start"} (${unit})`;
  const axes = new Axes(pen, width, height, x, { low: factor * low, high: factor * high || 1, label }, legend);
  lines.forEach(([, values], k) => {
    axes.line(
      xs,
      values.map((value) => factor * value),
      { colour: ink.bodies[k], dash: DASHES[k], width: 1.8 },
    );
  });
  return axes.follow(x, head);
}

function waiting(pen, width, height) {
  pen.fillStyle = ink.grey;
  pen.font = `12px ${FONT}`;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.fillText(perTurn ? "the first turn is being stepped …" : "being stepped …", width / 2, height / 2);
}
