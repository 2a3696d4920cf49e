// The mechanism as a drawing that is edited with the mouse. Python applies every operation to the text of the model and answers
// with the text, the ideal motion and, if the mechanism does not close, why. Nothing of the model is decided session.

class Sketch extends Paper {
  // `send(operation)` asks Python, `keep(answer)` makes its text the model, `tell(text)` shows a sentence, `showText(text)` the text
  // of the model, and `select(part)` the fields of what is selected.
  constructor(canvas, bubble, { send, keep, tell, showText, select }) {
    super(canvas);
    Object.assign(this, { bubble, send, keep, tell, showText, select, drag: null, queue: Promise.resolve(), sentence: null });
    this.tools = Object.fromEntries(Object.entries(TOOLS).map(([name, Kind]) => [name, new Kind(this)]));
    this.tool = this.tools.select;
    canvas.onpointerdown = (event) => this.press(event);
    canvas.onpointermove = (event) => this.move(event);
    canvas.onpointerup = (event) => this.release(event);
    canvas.onpointercancel = () => this.cancel();
    canvas.onpointerleave = () => this.tool.leave();
    canvas.ondblclick = () => this.tool === this.tools.select && this.fit();
  }

  // ------------------------------------------------------------------------------------------------------------- contents

  // Show a text; the view remains if it is of the same model.
  async show(text, switched) {
    this.base = text;
    const answer = await this.send({ text });
    if (this.base !== text) return;
    if (!answer.ok) return this.tell(sentences(answer));
    this.take(answer.said);
    if (switched || !this.view.scale) this.fit();
  }

  take(said) {
    this.drawing = new Drawing(said);
    this.showText(said.text);
    this.tell(said.fault || said.note);
    this.choose(this.chosen);
    this.tool.renew(this.drawing);
  }

  // Select a part by its name, which survives a new drawing.
  choose(part) {
    this.chosen = part && this.drawing.found(part);
    this.select(this.chosen);
  }

  // Apply an operation and keep its result.
  apply(operation, args, at) {
    return this.edit((ask) => ask(operation, args), at);
  }

  // Apply operations one after the other and keep the last result as one change; return whether none was refused. `act` calls
  // `ask(operation, arguments)`, which returns the new parts by their kind. A refusal is shown at the place `at` in metres.
  edit(act, at) {
    const done = this.queue.then(() => this.steps(act, at));
    this.queue = done.catch(() => false);
    return done;
  }

  async steps(act, at) {
    let last = null;
    let previous = this.drawing;
    const ask = async (operation, args) => {
      const answer = await this.send({ text: last?.text ?? this.base, operation, arguments: args });
      if (!answer.ok) throw new Refusal(sentences(answer));
      last = answer.said;
      const parts = new Drawing(last).novelties(previous);
      previous = new Drawing(last);
      return parts;
    };
    try {
      this.hush();
      await act(ask);
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      this.refuse(error.message, at);
      return false;
    }
    if (!last) return true;
    this.base = last.text;
    this.take(last);
    await this.keep(last);
    return true;
  }

  // Delete a part: of a point its joint or, without joints, its pin.
  remove(part, at) {
    const { knot } = part;
    if (knot?.joints.length > 1) {
      this.choose(part);
      return this.refuse(`Here are the joints ${knot.joints.join(" and ")}: delete one of them above the drawing.`, at);
    }
    const [section, name] = knot ? (knot.joints.length ? ["joint", knot.joints[0]] : ["pin", knot.pins[0]]) : Object.entries(part)[0];
    return this.apply("delete", { section, name }, at);
  }

  // ------------------------------------------------------------------------------------------------------------- sentences

  // Show a sentence at a place in metres, above the drawing if there is none.
  refuse(text, at) {
    if (!at) return this.tell(text);
    this.sentence = at;
    this.bubble.textContent = text;
    this.bubble.hidden = false;
    this.settle();
  }

  hush() {
    this.sentence = null;
    this.bubble.hidden = true;
  }

  // Keep the sentence beside its place and on the paper.
  settle() {
    if (!this.sentence) return;
    const [wide, tall] = this.view.box;
    const [x, y] = this.view.to(this.sentence);
    const { offsetWidth, offsetHeight } = this.bubble;
    this.bubble.style.left = `${Math.max(Math.min(x - offsetWidth / 2, wide - offsetWidth - 6), 6)}px`;
    const fits = y + 22 + offsetHeight < tall;
    this.bubble.style.top = `${Math.max(fits ? y + 22 : y - 22 - offsetHeight, 6)}px`;
  }

  // ------------------------------------------------------------------------------------------------------------- pointer

  use(name) {
    this.hush();
    this.cancel();
    this.tool.leave();
    this.tool.stop();
    this.tool = this.tools[name];
    this.canvas.style.cursor = this.tool.cursor;
  }

  press(event) {
    if (!this.drawing || event.button > 0) return;
    const pixel = this.pixel(event);
    this.canvas.setPointerCapture(event.pointerId);
    this.hush();
    this.drag = { pixel, at: this.view.from(pixel), moved: false };
    this.tool.press(this.drag, event);
  }

  move(event) {
    if (!this.drawing) return;
    const pixel = this.pixel(event);
    const { drag } = this;
    if (drag && !drag.moved && away(pixel, drag.pixel) < 4) return;
    if (drag) drag.moved = true;
    this.tool.point(pixel, event);
    if (drag) this.tool.pull(drag, pixel, event);
  }

  release(event) {
    const { drag } = this;
    this.drag = null;
    if (drag) this.tool.release(drag, this.pixel(event), event);
  }

  cancel() {
    const { drag } = this;
    this.drag = null;
    if (drag) this.tool.cancel(drag);
  }

  // ------------------------------------------------------------------------------------------------------------- drawing

  // Whether bodies are drawn at the start only.
  get still() {
    return this.drag?.part;
  }

  above(pen) {
    this.tool.draw(pen);
    this.settle();
  }
}

class Refusal extends Error {}

const sentences = ({ faults }) => faults.map((fault) => fault.said).join(" ");
