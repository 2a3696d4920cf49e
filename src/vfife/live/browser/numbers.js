// Motion, forces and energies of an output, computed from its rows by the formulas of vfife.measures.

// Map from names chosen by the user; without a prototype, so that "constructor" is a name like any other.
const blank = () => Object.create(null);

const TORQUE = "torque of "; // prefix of a driven body's name, where a chart shows its torque instead of a joint force

const PATH_LASTS = 8; // s in which all equilibria of a static analysis are played

// Crank angle in degrees, 0 to 360, with the tolerance of within_turn in Python.
const withinTurn = (degrees) => Math.max(((((degrees + 1e-6) % 360) + 360) % 360) - 1e-6, 0);

// Split a curve over the crank angle at the end of a turn, with interpolated points at both ends of the axis.
function overTurn(rotation, values) {
  const [xs, ys] = [[], []];
  rotation.forEach((degrees, k) => {
    const [x, previous] = [withinTurn(degrees), withinTurn(rotation[Math.max(k - 1, 0)])];
    if (Math.abs(x - previous) > 180) {
      const end = previous > 180 ? 360 : 0;
      const share = Math.min(Math.max((end - previous) / (degrees - rotation[k - 1]), 0), 1);
      const atEnd = values[k - 1] + share * (values[k] - values[k - 1]);
      xs.push(end, end, 360 - end);
      ys.push(atEnd, Number.NaN, atEnd);
    }
    xs.push(x);
    ys.push(values[k]);
  });
  return [xs, ys];
}

class Reader {
  // `sim`: indices of rows (payload.stepped), `state`: start state, `setting`: clearances and contact energies.
  constructor(sim, state, setting) {
    this.sim = sim;
    this.rows = sim.rows;
    this.width = sim.kept.length;
    this.columns = new Int32Array(Math.max(...sim.kept, 0) + 1).fill(-1);
    sim.kept.forEach((row, column) => {
      this.columns[row] = column;
    });
    this.state = state;
    this.dt = state[this.rows.step[0]];
    this.zeta = given.damped ? 0.5 * this.dt * state[this.rows.damping[0]] : 0;
    this.interval = given.factors ? PATH_LASTS / given.outputs : this.dt * sim.every;
    this.plays = setting.part("plays");
    this.energies = setting.part("energies");
    this.free = new Set(sim.free);
    this.found = blank();
    this.squares = blank(); // columns of the largest squared force, by joint
    this.first = null; // the rows of output 0
  }

  // Columns of a block of the state, one per entity.
  of(name) {
    if (!(name in this.found)) this.found[name] = Int32Array.from(this.rows[name] ?? [], (row) => this.columns[row]);
    return this.found[name];
  }

  parameter(name, index) {
    return this.state[this.rows[name][index]];
  }

  // ------------------------------------------------------------------------------------------------------------ motion

  // Position of a particle between two outputs: x, y, angle. `at` and `next` are offsets into `data`.
  particle(data, at, next, share, p) {
    const [x, y, angle] = [this.of("particle_x")[p], this.of("particle_y")[p], this.of("particle_theta")[p]];
    const interpolated = (c) => data[at + c] + share * (data[next + c] - data[at + c]);
    return [interpolated(x), interpolated(y), interpolated(angle)];
  }

  // Velocity of a particle at t_n: u, v, w. The rows contain it at t_n + step/2; half a step of the acceleration is subtracted.
  velocity(data, at, p) {
    return ["u", "v", "w"].map((name, axis) => {
      const half = data[at + this.of(`particle_${name}`)[p]];
      if (!this.free.has(p)) return half;
      return (half - 0.5 * this.dt * data[at + this.of(`particle_${["ax", "ay", "aw"][axis]}`)[p]]) / (1 - this.zeta);
    });
  }

  // Position and velocity of a point that moves with a particle: x, y, vx, vy.
  point(data, at, [p, px, py]) {
    const [x, y, angle] = this.particle(data, at, at, 0, p);
    const [u, v, w] = this.velocity(data, at, p);
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const [rx, ry] = [c * px - s * py, s * px + c * py];
    return [x + rx, y + ry, u - w * ry, v + w * rx];
  }

  // Rotation of the crank (degrees) after some turns, not reduced to one turn.
  rotation(turns) {
    const p = this.sim.driven[0];
    return (180 / Math.PI) * this.parameter("particle_theta", p) + (this.parameter("particle_w", p) < 0 ? -360 : 360) * turns;
  }

  // Angle and angular velocity of a body; of an elastic link those of its chord.
  turn(data, at, body) {
    if (!body.chord) {
      const p = body.particles[0];
      return [data[at + this.of("particle_theta")[p]], this.velocity(data, at, p)[2]];
    }
    const [a, b] = [body.particles[0], body.particles.at(-1)];
    const start = this.point(data, at, [a, 0, 0]);
    const end = this.point(data, at, [b, 0, 0]);
    const [dx, dy, du, dv] = end.map((value, k) => value - start[k]);
    return [Math.atan2(dy, dx), (dx * dv - dy * du) / (dx * dx + dy * dy)];
  }

  // ------------------------------------------------------------------------------------------------------------ forces

  // Journal's centre relative to the bearing's pin, in global axes (m).
  eccentricity(data, at, k) {
    const contact = given.contacts[k];
    const seen = (side) => {
      const [x, y, angle] = this.particle(data, at, at, 0, contact[side]);
      const [px, py] = [this.parameter(`contact_${side}_x`, k), this.parameter(`contact_${side}_y`, k)];
      const [c, s] = [Math.cos(angle), Math.sin(angle)];
      return [x + c * px - s * py, y + s * px + c * py];
    };
    const [journal, bearing] = [seen("journal"), seen("bearing")];
    return [journal[0] - bearing[0], journal[1] - bearing[1]];
  }

  // Force of a joint on its journal (N): x and y.
  force(data, at, name) {
    const { block, at: places } = this.sim.joints[name];
    if (block !== "contact") {
      const sign = block === "driven" && given.joints.find((joint) => joint.name === name)?.turned ? -1 : 1;
      return ["fx", "fy"].map((axis) => sign * data[at + this.of(`${block}_${axis}`)[places[0]]]);
    }
    const sum = [0, 0];
    for (const k of places) {
      const n = [data[at + this.of("nx")[k]], data[at + this.of("ny")[k]]]; // the normal force acts on the journal against it
      const [press, rub] = [data[at + this.of("contact_normal_force")[k]], data[at + this.of("contact_friction_force")[k]]];
      sum[0] += -rub * n[1] - press * n[0];
      sum[1] += rub * n[0] - press * n[1];
    }
    return sum;
  }

  // Quantity of a chart: magnitude of a joint's force (N), or torque of a driver (N m).
  size(data, at, name) {
    if (name.startsWith(TORQUE)) return data[at + this.of("driven_torque")[this.sim.torques[name.slice(TORQUE.length)]]];
    return Math.hypot(...this.force(data, at, name));
  }

  // Largest joint force (N) or torque (N m) over the steps since the previous output.
  forceMax(data, at, name) {
    if (given.factors) return Math.abs(this.size(data, at, name)); // there are no steps between equilibria
    if (name.startsWith(TORQUE)) return data[at + this.of("driven_torque_max")[this.sim.torques[name.slice(TORQUE.length)]]];
    const { block, at: places } = this.sim.joints[name].most;
    this.squares[name] ??= Int32Array.from(places, (k) => this.of(`${block}_force_squared_max`)[k]);
    let largest = 0;
    for (const column of this.squares[name]) largest = Math.max(largest, data[at + column]);
    return Math.sqrt(largest);
  }

  // ---------------------------------------------------------------------------------------------------------- energies

  // Energies and works (J) of an output; `start` says that it is output 0.
  ledger(data, at, start = false) {
    const sum = (name) => this.of(name).reduce((total, column) => total + data[at + column], 0);
    const work = (name) => sum(`${name}_work`) - 0.5 * this.dt * sum(`${name}_power`);
    return {
      kinetic: this.kinetic(data, at, start),
      strain: this.strain(data, at),
      contact: this.stored(data, at),
      spring: sum("spring_energy"),
      "lost in contacts": work("contact_damping"),
      "lost in friction": work("contact_friction"),
      "lost in damping": work("damping"),
      "lost in springs": work("spring_damping"),
      loads: work("external") + this.constant(data, at),
      drivers: work("driven") + work("actuator"),
    };
  }

  kinetic(data, at, start) {
    let total = 0;
    for (const p of this.sim.free) {
      const velocity = this.velocity(data, at, p);
      ["u", "v", "w"].forEach((name, axis) => {
        const inverse = this.parameter(axis < 2 ? "particle_inverse_mass" : "particle_inverse_inertia", p);
        if (!(inverse > 0)) return;
        const next = data[at + this.of(`particle_${name}`)[p]];
        const previous = 2 * velocity[axis] - next;
        total += (0.5 * (start ? velocity[axis] ** 2 : 0.5 * (previous * previous + next * next))) / inverse;
      });
    }
    this.sim.driven.forEach((p, k) => {
      total += 0.5 * this.velocity(data, at, p)[2] ** 2 * this.parameter("driven_inertia", k);
    });
    return total;
  }

  strain(data, at) {
    return this.of("frame_axial_force").reduce((total, column, k) => {
      const present = this.sim.present[k];
      const length = present ? data[at + this.of("reference_length")[k]] : 1 / this.parameter("reference_inverse_length", k);
      const [ea, ei] = [this.parameter("frame_axial_stiffness", k), this.parameter("frame_bending_stiffness", k)];
      const [first, second] = [data[at + this.of("frame_moment_1")[k]], data[at + this.of("frame_moment_2")[k]]];
      const e = data[at + column] / ea;
      const small = Math.abs(e) < 0.01; // where the difference would lose digits
      const share = !present ? 0.5 * e * e : small ? 0.5 * e * e * (1 - (e / 3) * (1 - (e / 4) * (1 - (e / 5) * (1 - e / 6)))) : e + Math.expm1(-e);
      return total + ea * length * share + (ei > 0 ? (length / (6 * ei)) * (first * first - first * second + second * second) : 0);
    }, 0);
  }

  // Elastic energy of the contacts (J), by a power law between the depths at which Python computed it.
  stored(data, at) {
    const { depths } = given;
    return this.of("contact_penetration").reduce((total, column, k) => {
      const depth = data[at + column];
      if (!(depth > 0)) return total;
      const scale = ((depths.length - 1) * Math.log(depth / depths[0])) / Math.log(depths.at(-1) / depths[0]);
      const low = Math.min(Math.max(Math.floor(scale), 0), depths.length - 2);
      const [lower, upper] = [this.energies[k * depths.length + low], this.energies[k * depths.length + low + 1]];
      return total + 10 ** (lower + (scale - low) * (upper - lower));
    }, 0);
  }

  // Work (J) of constant loads and gravity since output 0.
  constant(data, at) {
    const { first } = this;
    if (!first) return 0;
    let total = 0;
    for (const [axis, load] of [
      ["x", "x"],
      ["y", "y"],
      ["theta", "m"],
    ]) {
      const column = this.of(`particle_${axis}`);
      this.rows[`particle_load_${load}`].forEach((row, p) => {
        total += (data[at + column[p]] - first[column[p]]) * this.state[row];
      });
    }
    this.sim.driven.forEach((p, k) => {
      const [mx, my, gx, gy] = ["moment_x", "moment_y", "weight_x", "weight_y"].map((name) => this.parameter(`driven_${name}`, k));
      const height = (angle) => gx * (Math.cos(angle) * mx - Math.sin(angle) * my) + gy * (Math.sin(angle) * mx + Math.cos(angle) * my);
      const column = this.of("particle_theta")[p];
      total += height(data[at + column]) - height(first[column]);
    });
    return total;
  }
}

const STORED = ["kinetic", "strain", "contact", "spring"];
const LOST = ["lost in contacts", "lost in friction", "lost in damping", "lost in springs"];
const SUPPLIED = ["loads", "drivers"];
const summed = (terms, names) => names.reduce((total, name) => total + terms[name], 0);
