// The tools of the drawing: each makes operations of what the pointer does on the paper. Python applies them or says why not.

class Tool {
  constructor(sketch) {
    Object.assign(this, { sketch, cursor: "crosshair", hint: "", target: null });
  }

  // What is under a pixel: a point, a body with the place on it, or a place of the paper. `others` are points and names of bodies
  // that are passed over; with the Alt key all are.
  aim(pixel, event, others = []) {
    const { drawing, view } = this.sketch;
    const [at, tolerance] = [view.from(pixel), NEAR / view.scale];
    if (event.altKey) return { at };
    const knot = drawing.knotNear(at, tolerance, others);
    if (knot) return { at: knot.at, knot };
    const body = drawing.bodyNear(at, tolerance, others);
    return body ? { at: drawing.foot(body, at), body: body.name } : { at: view.rounded(at) };
  }

  point(pixel, event) {
    this.target = this.aim(pixel, event);
  }

  press() {}

  pull(_drag, _pixel, event) {
    this.sketch.view.moved(event.movementX, event.movementY);
  }

  release(drag, pixel, event) {
    if (!drag.moved) this.act(this.aim(pixel, event), pixel);
  }

  cancel() {}

  leave() {
    this.target = null;
  }

  // End of the use of a tool, also in the middle of a gesture.
  stop() {}

  // Keep what was taken hold of in a new drawing.
  renew() {}

  // Pin at a target; one on a body is added there.
  async pin(ask, { knot, body, at: [x, y] }) {
    return knot ? knot.pins[0] : (await ask("add_pin", { body, x, y })).pin;
  }

  draw(pen) {
    if (this.target) this.ring(pen, this.target);
  }

  // Show what a target takes hold of: a ring around a point or a place on a body, a cross on the paper.
  ring(pen, { at, knot, body }, colour = ink.accent) {
    const [x, y] = this.sketch.view.to(at);
    pen.strokeStyle = colour;
    pen.lineWidth = 2;
    pen.setLineDash([]);
    if (knot || body) {
      pen.beginPath();
      pen.arc(x, y, knot ? 12 : 7, 0, 2 * Math.PI);
      pen.stroke();
    } else {
      segment(pen, [x - 6, y], [x + 6, y]);
      segment(pen, [x, y - 6], [x, y + 6]);
    }
  }

  label(pen, text, at, colour = ink.accent) {
    const [x, y] = this.sketch.view.to(at);
    this.sketch.labels.write(
      pen,
      text,
      [
        [x + 18, y + 20, "left"],
        [x + 18, y - 20, "left"],
        [x - 18, y + 20, "right"],
      ],
      colour,
    );
  }
}

// Select parts, and drag points and lengths.
class SelectTool extends Tool {
  constructor(sketch) {
    super(sketch);
    Object.assign(this, { cursor: "default", busy: false, hint: "Drag a point or the diamond of a length; the wheel zooms." });
  }

  point(pixel) {
    if (this.sketch.drag) return;
    const part = this.sketch.part(pixel);
    this.sketch.canvas.style.cursor = part?.knot || part?.length ? "grab" : part ? "pointer" : "default";
  }

  press(drag) {
    const part = this.sketch.part(drag.pixel);
    drag.part = part?.knot || part?.length ? part : null;
    this.sketch.choose(part?.length ? { body: part.length } : part);
  }

  pull(drag, pixel, event) {
    if (!drag.part) return super.pull(drag, pixel, event);
    this.sketch.canvas.style.cursor = "grabbing";
    drag.operation = this.operation(drag, this.sketch.view.from(pixel), event.altKey);
    this.ask(drag);
  }

  // Operation of dragging what was taken hold of to a place.
  operation(drag, place, exactly) {
    const { drawing, view } = this.sketch;
    const { part, at } = drag;
    const by = [place[0] - at[0], place[1] - at[1]];
    if (part.knot) {
      const [x, y] = exactly ? place : view.rounded(plus(part.knot.at, by));
      return { operation: "move_point", arguments: { point: part.knot.pins[0], x, y } };
    }
    const k = drawing.index.get(part.length);
    drag.length ??= drawing.bodies[k].length;
    drag.angle ??= drawing.poses[0][k][2];
    const [advance] = turned(-drag.angle, by);
    const [length] = exactly ? [drag.length + advance] : view.rounded([drag.length + advance]);
    return { operation: "set_length", arguments: { body: part.length, length: Math.max(length, 2 / view.scale) } };
  }

  // Ask for the last operation of a drag; one request at a time, so that the drawing follows as fast as Python answers.
  async ask(drag) {
    if (this.busy) return;
    this.busy = true;
    const { sketch } = this;
    await sketch.queue;
    while (drag.operation && drag.operation !== drag.sent) {
      drag.sent = drag.operation;
      const answer = await sketch.send({ text: sketch.base, ...drag.sent });
      if (drag.cancelled) break;
      drag.answer = answer.ok ? answer.said : drag.answer;
      if (answer.ok) sketch.take(answer.said);
      else sketch.tell(sentences(answer));
    }
    this.busy = false;
    if (drag.ended || drag.cancelled) this.finish(drag);
  }

  release(drag) {
    this.sketch.canvas.style.cursor = "default";
    if (!drag.operation) return;
    drag.ended = true;
    if (!this.busy) this.finish(drag);
  }

  async finish(drag) {
    const { sketch } = this;
    if (drag.cancelled || !drag.answer) return sketch.show(sketch.base);
    sketch.base = drag.answer.text;
    await sketch.keep(drag.answer);
  }

  cancel(drag) {
    if (!drag.operation) return;
    drag.cancelled = true;
    if (!this.busy) this.finish(drag);
  }

  draw() {}
}

// A tool that needs two places: two clicks, or one drag from the first to the second.
class PairTool extends Tool {
  constructor(sketch) {
    super(sketch);
    this.first = null;
  }

  press(drag, event) {
    drag.first = !this.first;
    this.first ??= this.aim(drag.pixel, event);
    this.point(drag.pixel, event);
  }

  point(pixel, event) {
    this.target = this.first ? this.second(pixel, event) : this.aim(pixel, event);
  }

  second(pixel, event) {
    return this.aim(pixel, event, this.first.knot ? [this.first.knot] : []);
  }

  pull() {}

  release(drag, pixel, event) {
    if (!this.first || (drag.first && !drag.moved)) return;
    const { first } = this;
    const second = this.second(pixel, event);
    this.first = null;
    this.act(first, second);
  }

  cancel() {
    this.first = null;
  }

  stop() {
    this.first = null;
  }

  renew(drawing) {
    const { knot, body } = this.first ?? {};
    const found = knot || body ? drawing.found({ knot, body }) : {};
    this.first = this.first && found && { ...this.first, ...found, at: found.knot?.at ?? this.first.at };
    this.target = null;
  }

  draw(pen) {
    const { view } = this.sketch;
    super.draw(pen);
    if (!this.first) return;
    this.ring(pen, this.first);
    if (!this.target) return;
    pen.setLineDash([8, 5]);
    segment(pen, view.to(this.first.at), view.to(this.target.at));
    pen.setLineDash([]);
    this.label(pen, this.words(), this.target.at);
  }
}
