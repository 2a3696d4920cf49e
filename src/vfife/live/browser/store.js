// Ring buffer of the last outputs, and the largest values of each turn.

const MOST_BYTES = 64e6;
const TURNS = 6; // turns in the buffer, over which ranges are shown

class Store {
  constructor(width, wanted) {
    this.width = width;
    this.capacity = Math.max(16, Math.min(wanted, Math.floor(MOST_BYTES / (8 * width))));
    this.data = new Float64Array(width * this.capacity);
    this.end = 0; // number of outputs received; output n is at index n % capacity
  }

  get begin() {
    return Math.max(0, this.end - this.capacity);
  }

  offset(output) {
    return (output % this.capacity) * this.width;
  }

  put(first, rows, count) {
    if (first !== this.end) return;
    for (let k = 0; k < count; k++) this.data.set(rows.subarray(k * this.width, (k + 1) * this.width), this.offset(first + k));
    this.end += count;
  }
}

// Largest values by turn; without a crank the whole run is one turn.
class Turns {
  constructor(reader, perTurn, bodies) {
    Object.assign(this, { reader, perTurn, bodies });
    this.done = []; // complete turns: { first, force: {joint: N}, alpha: {body: rad/s²}, depth: [m], began: [1] }
    this.open = null; // the turn in progress
    this.before = null; // onsets of contacts at the end of the previous turn
  }

  take(data, at, output) {
    const { reader } = this;
    const began = Array.from(reader.of("contact_onsets"), (column) => data[at + column]);
    if (output === 0) {
      reader.first = data.slice(at, at + reader.width);
      this.before = began;
      return;
    }
    this.open ??= { first: output - 1, force: blank(), torque: blank(), alpha: blank(), depth: [], began: [] };
    const { force, torque, alpha, depth } = this.open;
    for (const name of Object.keys(reader.sim.joints)) force[name] = Math.max(force[name] ?? 0, reader.forceMax(data, at, name));
    for (const name of Object.keys(reader.sim.torques)) {
      torque[name] = Math.max(torque[name] ?? 0, reader.forceMax(data, at, TORQUE + name));
    }
    for (const body of this.bodies) {
      alpha[body.name] = Math.max(alpha[body.name] ?? 0, data[at + reader.of("body_alpha_max")[reader.sim.alphas[body.name]]]);
    }
    reader.of("contact_penetration_max").forEach((column, k) => {
      depth[k] = Math.max(depth[k] ?? Number.NEGATIVE_INFINITY, data[at + column]);
    });
    this.open.last = output;
    this.open.began = began.map((count, k) => count - this.before[k]);
    if (this.perTurn && output % this.perTurn === 0) {
      this.done.push(this.open);
      if (this.done.length > TURNS) this.done.shift();
      this.open = null;
      this.before = began;
    }
  }

  // Complete turns without the first one, which contains the start, if there are others; else the turn in progress.
  get shown() {
    const settled = this.done.filter((turn) => turn.first > 0);
    return settled.length > 1 ? settled : this.done.length ? this.done : this.open ? [this.open] : [];
  }

  // Numbers of the turns shown, as text.
  get words() {
    const [first, last] = [this.shown[0], this.shown.at(-1)].map((turn) => Math.floor((turn?.first ?? 0) / this.perTurn) + 1);
    return first === last ? `turn ${first}` : `turns ${first}–${last}`;
  }
}
