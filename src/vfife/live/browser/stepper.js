// Worker: steps the mechanism, and its ideal reference for one turn, and sends the rows of outputs as they are computed.
// The text before this file defines `steps`: one function advance for each of the two, as described in kernels/advance.py.

const LOOK = 1000; // steps between two checks that numbers are finite
const SLICE = 14; // ms of stepping between two returns to the event loop, which delivers new requests; one frame at 60 Hz

// One simulation: a state, its tables, and the step it has reached.
class Stepper {
  constructor(advance, given, state, tables) {
    this.given = given;
    this.state = state;
    const { kept, extremes, again } = given;
    const copy = () => new Float64Array(state.length);
    const scratch = [copy(), copy(), new Float64Array(3)];
    const shares = new Float64Array(1),
      broken = new Float64Array(1);
    const numbers = [1, 1, state.length, again, LOOK];
    const memory = [state, ...scratch, tables, [], numbers, shares, kept, extremes, [], [], broken]; // Memory of kernels/advance.py
    this.advance = (...last) => advance(memory, ...last);
    this.next = 0; // step
    this.outputs = 0; // number computed
    this.sound = true;
  }

  // Compute rows of at most `count` outputs; fewer if the time `until` (ms) is reached or a number becomes non-finite.
  take(count, until) {
    const { kept, every } = this.given;
    const rows = new Float64Array(count * kept.length);
    let made = 0;
    while (made < count && this.sound) {
      const steps = this.next === 0 ? 1 : every;
      const at = made * kept.length;
      this.advance(1, LOOK - (this.next % LOOK), this.next, steps, 1, rows.subarray(at));
      this.next += steps;
      for (let k = at; k < at + kept.length; k++) {
        rows[k] += 0; // recorded zeros are positive, as in Python: -0 + 0 is +0
        if (!Number.isFinite(rows[k])) this.sound = false;
      }
      if (!this.sound) break;
      made++;
      if (performance.now() > until) break;
    }
    const first = this.outputs;
    this.outputs += made;
    return { first, count: made, rows: rows.subarray(0, made * kept.length) };
  }
}

let given = null; // { own, ideal } as the page has them
let run = null; // { id, steppers, until }
let waiting = false;

// Start a run with the numbers of a setting, which follow each other in the order of given.parts.
function begin(message) {
  const { parts } = given;
  const at = {};
  let from = 0;
  for (const [name, length] of Object.entries(parts)) {
    at[name] = message.vector.slice(from, from + length);
    from += length;
  }
  const steppers = [new Stepper(steps[0], given.own, at.state, at.tables)];
  if (given.ideal) steppers.push(new Stepper(steps[1], given.ideal, at.ideal_state, at.ideal_tables));
  run = { id: message.id, steppers, until: [message.until, given.ideal ? given.ideal.perTurn + 1 : 0] };
}

// Whether the first turn of the mechanism is complete; its ideal reference is computed next.
function perTurnIsThere() {
  return Boolean(given.ideal) && run.steppers[0].outputs > given.ideal.perTurn;
}

// Compute one slice of the requested outputs. The mechanism comes first, since it is what the user sees; after its first turn
// the reference does, because comparisons need it.
function slice() {
  waiting = false;
  if (!run) return;
  const began = performance.now();
  const first = perTurnIsThere() ? [1, 0] : [0, 1];
  for (const k of first) {
    const stepper = run.steppers[k];
    if (!stepper?.sound || stepper.outputs >= run.until[k]) continue;
    const made = stepper.take(Math.min(run.until[k] - stepper.outputs, 4096), began + SLICE);
    const rows = made.rows.slice();
    const message = { id: run.id, which: k, first: made.first, count: made.count, rows, sound: stepper.sound, wall: performance.now() - began };
    self.postMessage(message, [rows.buffer]);
    break;
  }
  again();
}

function again() {
  const open = run?.steppers.some((stepper, k) => stepper.sound && stepper.outputs < run.until[k]);
  if (!open || waiting) return;
  waiting = true;
  setTimeout(slice, 0);
}

self.onmessage = ({ data }) => {
  if (data.kind === "given") given = data.given;
  if (data.kind === "begin") begin(data);
  if (data.kind === "until" && run && data.id === run.id) run.until[0] = data.until;
  again();
};
