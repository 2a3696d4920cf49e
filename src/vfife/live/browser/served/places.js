// Geometry of a sketch: the view of the plane, the places of pins at the start and through the motion, and what is under the pointer.

const NEAR = 14; // pixels within which the pointer takes hold of a point
const FINER = 4; // places of a curve between two poses

// Map between metres and pixels.
class View {
  constructor() {
    Object.assign(this, { scale: 0, middle: [0, 0], box: [1, 1] });
  }

  // Show all places, with room for signs and names.
  fit(places, size) {
    const [low, high] = [Math.min, Math.max].map((most) => [0, 1].map((axis) => most(...places.map((place) => place[axis]))));
    const [wide, tall] = [0, 1].map((axis) => Math.max(high[axis] - low[axis], 0.05 * size));
    this.middle = [0, 1].map((axis) => 0.5 * (low[axis] + high[axis]));
    this.scale = Math.min(Math.max(this.box[0] - 110, 60) / wide, Math.max(this.box[1] - 110, 60) / tall);
  }

  to([x, y]) {
    return [this.box[0] / 2 + this.scale * (x - this.middle[0]), this.box[1] / 2 - this.scale * (y - this.middle[1])];
  }

  from([px, py]) {
    return [this.middle[0] + (px - this.box[0] / 2) / this.scale, this.middle[1] - (py - this.box[1] / 2) / this.scale];
  }

  moved(dx, dy) {
    this.middle = [this.middle[0] - dx / this.scale, this.middle[1] + dy / this.scale];
  }

  // Zoom by a factor about a pixel.
  zoomed(factor, pixel) {
    const previous = this.from(pixel);
    this.scale *= factor;
    const moved = this.from(pixel);
    this.middle = [0, 1].map((axis) => this.middle[axis] + previous[axis] - moved[axis]);
  }

  // Round a place to a step that suits the scale: 1, 2 or 5 of a power of ten.
  rounded(place) {
    const smallest = 3 / this.scale;
    const power = 10 ** Math.floor(Math.log10(smallest));
    const step = power * [1, 2, 5, 10].find((factor) => factor * power >= smallest);
    return place.map((value) => Number((Math.round(value / step) * step).toPrecision(12)));
  }
}

const turned = (angle, [x, y]) => [Math.cos(angle) * x - Math.sin(angle) * y, Math.sin(angle) * x + Math.cos(angle) * y];
const plus = ([a, b], [x, y]) => [a + x, b + y];
const away = ([a, b], [x, y]) => Math.hypot(a - x, b - y);

// What the server says of a text, with places at the start and through the ideal motion.
class Drawing {
  constructor(said) {
    Object.assign(this, said);
    this.index = new Map(this.bodies.map((body, k) => [body.name, k]));
    this.knots = this.clusters();
    this.curves = this.poses.length > 1 ? this.knots.map((knot) => this.curve(knot.pins[0])) : [];
  }

  // Pose of all bodies at a place on the motion, from 0 to 1.
  pose(share) {
    const count = this.poses.length;
    const at = this.closed ? share * count : share * (count - 1);
    const k = Math.min(Math.floor(at), count - 1);
    const stations = [-1, 0, 1, 2].map((by) => this.poses[this.closed ? (k + by + count) % count : Math.min(Math.max(k + by, 0), count - 1)]);
    return stations[1].map((_, body) =>
      between(
        stations.map((pose) => pose[body]),
        at - k,
      ),
    );
  }

  place(pin, pose = this.poses[0]) {
    const [body, name] = split(pin);
    if (body === "ground") return this.points[name];
    const k = this.index.get(body);
    return this.inBody(k, this.bodies[k].pins[name] ?? [0, 0], pose);
  }

  inBody(k, local, pose = this.poses[0]) {
    const [x, y, angle] = pose[k];
    return plus([x, y], turned(angle, local));
  }

  // Places of a pin through the motion.
  curve(pin) {
    const count = FINER * this.poses.length;
    return Array.from({ length: count + 1 }, (_, k) => this.place(pin, this.pose(Math.min(k / count, this.closed ? 1 - 1e-9 : 1))));
  }

  // Points of the drawing: pins that joints hold in one place are one point, named after their joints.
  clusters() {
    const pins = [
      ...Object.keys(this.points).map((name) => `ground.${name}`),
      ...this.bodies.flatMap((body) => Object.keys(body.pins).map((pin) => `${body.name}.${pin}`)),
    ];
    const of = new Map(pins.map((pin) => [pin, { pins: [pin], joints: [], at: this.place(pin) }]));
    for (const joint of this.joints.filter(({ pinned, name }) => pinned && !this.gaps.includes(name))) {
      const [first, second] = [of.get(joint.bearing), of.get(joint.journal)];
      if (!first || !second) continue;
      if (first !== second) {
        first.pins.push(...second.pins);
        first.joints.push(...second.joints);
        for (const pin of second.pins) of.set(pin, first);
      }
      first.joints.push(joint.name);
    }
    for (const joint of this.joints) {
      const knot = of.get(joint.journal);
      if (knot && !knot.joints.includes(joint.name)) knot.joints.push(joint.name);
    }
    return [...new Set(of.values())];
  }

  // All places that the motion reaches, with blocks in their guides.
  get reach() {
    const moving = this.poses.flatMap((pose) => this.bodies.flatMap((body, k) => body.outline.map((point) => this.inBody(k, point, pose))));
    const blocks = this.poses.flatMap((pose) =>
      this.joints.flatMap(({ journal, block }) => {
        const half = 0.5 * Math.hypot(...block);
        return half ? [-half, half].map((by) => plus(this.place(journal, pose), [by, by])) : [];
      }),
    );
    const places = [...moving, ...blocks, ...Object.values(this.points)];
    return places.length ? places : [[0, 0]];
  }

  // A part of another drawing in this one, by its name; null if it is not there.
  found({ knot, body, load, spring, driver }) {
    const knotHere = knot && this.knots.find(({ pins }) => pins.some((pin) => knot.pins.includes(pin)));
    if (knotHere) return { knot: knotHere };
    if (body && this.index.has(body)) return { body };
    if (load && this.loads.some(({ name }) => name === load)) return { load };
    if (spring && this.springs.some(({ name }) => name === spring)) return { spring };
    return driver && this.bodies.some((body) => body.driver?.name === driver) ? { driver } : null;
  }

  // Names of the parts by their kind, and of those that another drawing does not have, the last of each kind.
  get names() {
    const named = (parts) => parts.map(({ name }) => name);
    const pins = this.knots.flatMap((knot) => knot.pins);
    return { pin: pins, body: named(this.bodies), joint: named(this.joints), load: named(this.loads) };
  }

  novelties(before) {
    return Object.fromEntries(
      Object.entries(this.names).map(([kind, names]) => [kind, names.filter((name) => !before.names[kind].includes(name)).at(-1)]),
    );
  }

  // Point nearest to a place within some metres, but none of `others`.
  knotNear(place, near, others = []) {
    return least(
      this.knots.filter((knot) => !others.includes(knot)),
      (knot) => away(knot.at, place),
      near,
    );
  }

  // Body nearest to a place within some metres, but none of the names `others`.
  bodyNear(place, near, others = []) {
    return least(
      this.bodies.filter(({ name }) => !others.includes(name)),
      (body) => away(this.foot(body, place), place),
      near,
    );
  }

  // Link whose handle of its length is at a place within some metres.
  lengthNear(place, near) {
    return least(
      this.bodies.filter((body) => body.length),
      (body) => away(this.handle(body), place),
      near,
    );
  }

  // Place of the handle of a link's length.
  handle(body) {
    return this.inBody(this.index.get(body.name), [0.5 * body.length, 0]);
  }

  // Place on the outline of a body that is nearest to a place.
  foot(body, place) {
    const points = body.outline.map((point) => this.inBody(this.index.get(body.name), point));
    if (points.length < 2) return points[0] ?? [Number.POSITIVE_INFINITY, 0];
    const closed = body.plate ? [...points, points[0]] : points;
    const feet = closed.slice(1).map((to, k) => footOnLine(closed[k], to, place));
    return least(feet, (foot) => away(foot, place));
  }
}

// Item of the least distance, null if all are farther than `near`.
function least(items, distance, near = Number.POSITIVE_INFINITY) {
  const [first] = items.map((item) => [distance(item), item]).sort((a, b) => a[0] - b[0]);
  return first && first[0] <= near ? first[1] : null;
}

function footOnLine([ax, ay], [bx, by], [x, y]) {
  const size = (bx - ax) ** 2 + (by - ay) ** 2 || 1;
  const share = Math.min(Math.max(((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / size, 0), 1);
  return [ax + share * (bx - ax), ay + share * (by - ay)];
}

function split(pin) {
  const at = pin.indexOf(".");
  return [pin.slice(0, at), pin.slice(at + 1)];
}

// Cubic between the second and the third of four frames (x, y, angle), without a jump of a whole turn.
function between(frames, t) {
  const [, start] = frames;
  return [0, 1, 2].map((axis) => {
    const whole = (value) => (axis === 2 ? value - 2 * Math.PI * Math.round((value - start[2]) / (2 * Math.PI)) : value);
    const [a, b, c, d] = frames.map((frame) => whole(frame[axis]));
    return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
  });
}
