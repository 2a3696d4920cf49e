// The tools that add parts to the drawing and delete them, each by operations of Python.

// Add a link between two places. An end on a point or on a body is joined there; another is free.
class BodyTool extends PairTool {
  constructor(sketch) {
    super(sketch);
    this.hint =
      "Click both ends of the new link, or drag from one to the other. An end on a point or a body is joined to it; hold Alt to leave it free.";
  }

  words() {
    return millimetres(away(this.first.at, this.target.at));
  }

  act(first, second) {
    return this.sketch.edit(async (ask) => {
      const end = (target) => (target.knot || target.body ? this.pin(ask, target) : target.at);
      const start = await end(first);
      const { body } = await ask("add_bar", { start, end: await end(second) });
      this.sketch.chosen = { body };
    }, second.at);
  }
}

// Join two bodies, or hold a point on the ground.
class JointTool extends PairTool {
  constructor(sketch) {
    super(sketch);
    this.kind = "ideal";
    this.hint = "Click two points or bodies to join them; a point that is clicked twice is held on the ground.";
  }

  // The bodies of the first place are passed over; where nothing else is, it is the ground.
  second(pixel, event) {
    const { knot, body, at } = this.first;
    const excluded = knot ? [knot, ...knot.pins.map((pin) => split(pin)[0])] : [body];
    const target = this.aim(pixel, event, excluded);
    if (target.knot || target.body) return target;
    const { view } = this.sketch;
    return away(view.to(at), pixel) < NEAR ? { at, knot, ground: true } : target;
  }

  words() {
    const { knot, body, ground } = this.target;
    return ground ? "held on the ground" : knot ? knot.pins[0] : (body ?? "");
  }

  act(first, second) {
    const part = ({ knot, body }) => knot || body;
    if (!part(first) || !part(second)) {
      const words = "There is nothing to join: click a point or a body, then another one, or the same point again to hold it on the ground.";
      return this.sketch.refuse(words, (part(first) ? second : first).at);
    }
    return this.sketch.edit(async (ask) => {
      const pin = await this.pin(ask, first);
      const joint = second.ground ? await this.hold(ask, pin) : (await ask("add_joint", { first: pin, second: await this.pin(ask, second) })).joint;
      await ask("set_kind", { joint, choice: this.kind });
    }, second.at);
  }

  async hold(ask, point) {
    const guided = ["slider", "slot", "clearance-slider"].includes(this.kind);
    return (await ask(guided ? "add_slider" : "anchor", { point })).joint;
  }
}

// Add a point to the ground, or a pin to a body: pressed on the body and dragged to its place.
class PointTool extends Tool {
  constructor(sketch) {
    super(sketch);
    this.hint = "Click the background to add a point of the ground. For a pin of a body press on the body and drag to the place of the pin.";
  }

  press(drag, event) {
    drag.target = this.aim(drag.pixel, event);
    this.body = drag.target.body;
  }

  aim(pixel, event) {
    if (!this.sketch.drag?.moved || !this.body) return super.aim(pixel, event);
    const place = this.sketch.view.from(pixel);
    return { at: event.altKey ? place : this.sketch.view.rounded(place) };
  }

  pull(drag, pixel, event) {
    if (!this.body) super.pull(drag, pixel, event);
  }

  release(drag, pixel, event) {
    const { body } = this;
    this.body = null;
    if (drag.moved && !body) return;
    const { view } = this.sketch;
    const place = view.from(pixel);
    const at = drag.moved ? (event.altKey ? place : view.rounded(place)) : drag.target.at;
    const [x, y] = at;
    return this.sketch.edit(async (ask) => {
      const { pin } = await (body ? ask("add_pin", { body, x, y }) : ask("add_point", { x, y }));
      this.sketch.chosen = { knot: { pins: [pin] } };
    }, at);
  }

  stop() {
    this.body = null;
  }

  draw(pen) {
    super.draw(pen);
    const { drag, view } = this.sketch;
    if (!this.body || !drag || !this.target) return;
    pen.setLineDash([8, 5]);
    segment(pen, view.to(drag.target.at), view.to(this.target.at));
    pen.setLineDash([]);
    this.label(pen, this.body, this.target.at);
  }
}

// Add a force at a point, or at a place of a body.
class ForceTool extends Tool {
  constructor(sketch) {
    super(sketch);
    this.hint = "Click the point or the place on a body where the force acts; then give its size above.";
  }

  act(target) {
    if (!target.knot && !target.body) return this.sketch.refuse("A force acts on a body: click one of its points.", target.at);
    return this.sketch.edit(async (ask) => {
      const { load } = await ask("add_load", { point: await this.pin(ask, target) });
      this.sketch.chosen = { load };
    }, target.at);
  }
}

// Drive a body.
class DriverTool extends Tool {
  constructor(sketch) {
    super(sketch);
    this.hint = "Click the body that turns at a constant speed.";
  }

  aim(pixel, event) {
    const target = super.aim(pixel, event);
    const body = target.knot?.pins.map((pin) => split(pin)[0]).find((body) => body !== "ground");
    return target.knot ? { ...target, body } : target;
  }

  act(target) {
    const { body } = target;
    if (!body) return this.sketch.refuse("A driver turns a body: click one.", target.at);
    return this.sketch.edit(async (ask) => {
      await ask("drive", { body });
      this.sketch.chosen = { body };
    }, target.at);
  }

  draw(pen) {
    const body = this.target && this.sketch.drawing.bodies.find(({ name }) => name === this.target.body);
    if (body) this.sketch.mark(pen, { body: body.name }, ink.accent);
  }
}

// Delete the part under the pointer.
class DeleteTool extends Tool {
  constructor(sketch) {
    super(sketch);
    Object.assign(this, { part: null, hint: "Click the joint, body, force, driver or spring to be deleted, or a pin that nothing holds." });
  }

  point(pixel) {
    const part = this.sketch.part(pixel);
    this.part = part?.length ? { body: part.length } : part;
    this.sketch.canvas.style.cursor = part ? "pointer" : "crosshair";
  }

  leave() {
    this.part = null;
  }

  renew() {
    this.part = null;
  }

  act(_, pixel) {
    this.point(pixel);
    const { part, sketch } = this;
    this.part = null;
    return part && sketch.remove(part, sketch.view.from(pixel));
  }

  draw(pen) {
    if (this.part && !this.sketch.drag) this.sketch.mark(pen, this.part, ink.warm);
  }
}

const TOOLS = {
  select: SelectTool,
  body: BodyTool,
  point: PointTool,
  joint: JointTool,
  force: ForceTool,
  driver: DriverTool,
  delete: DeleteTool,
};
