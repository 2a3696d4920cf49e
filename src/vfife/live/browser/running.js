// A run of the mechanism with one setting of the sliders, in a worker, and its outputs so far.
//
// Messages to the worker: "given" (how to step, once), "begin" (numbers of a setting, with a new id), "until" (more outputs).
// Messages from it contain the id of their run; those of a former setting that are still on their way are ignored.

const workerPlace = URL.createObjectURL(new Blob([given.worker], { type: "text/javascript" }));
const { own, ideal, perTurn, outputs: wholeRun } = given;
const AHEAD = 1.25; // turns by which the worker is ahead of the picture
const turning = given.bodies.filter((body) => body.turns && body.driven === null);

class Running {
  constructor() {
    this.id = 0;
    this.worker = new Worker(workerPlace);
    this.worker.onmessage = ({ data }) => this.take(data);
    this.worker.onerror = (event) => showMessage(`The worker stopped: ${event.message}`);
    const { worker: _text, vector: _vector, groups: _groups, model: _model, ...rest } = given;
    this.worker.postMessage({ kind: "given", given: rest });
    this.steps = 0;
    this.spent = 0;
  }

  begin(setting, until) {
    this.id += 1;
    this.setting = setting;
    this.sound = true;
    this.reader = new Reader(own, setting.part("state"), setting);
    this.store = new Store(own.kept.length, perTurn ? Math.ceil((TURNS + AHEAD) * perTurn) + 2 : wholeRun + 1);
    this.turns = new Turns(this.reader, perTurn, turning);
    if (ideal) {
      this.idealReader = new Reader(ideal, setting.part("ideal_state"), setting);
      this.idealStore = new Store(ideal.kept.length, ideal.perTurn + 1);
      this.idealTurns = new Turns(this.idealReader, ideal.perTurn, turning);
    }
    this.until = until;
    this.worker.postMessage({ kind: "begin", id: this.id, vector: setting.vector, until });
  }

  ask(until) {
    if (until <= this.until) return;
    this.until = until;
    this.worker.postMessage({ kind: "until", id: this.id, until });
  }

  take({ id, which, first, rows, count, sound, wall }) {
    if (id !== this.id) return;
    const [store, turns] = which ? [this.idealStore, this.idealTurns] : [this.store, this.turns];
    store.put(first, rows, count);
    for (let k = 0; k < count; k++) turns.take(rows, k * store.width, first + k);
    if (which) return;
    this.steps += count * own.every;
    this.spent += wall;
    if (!sound) {
      this.sound = false;
      showMessage("The numbers grew without bound: the step is too large for this setting.");
    }
  }

  // Largest force of a joint, or angular acceleration of a body, in the ideal turn; null if negligible or unknown.
  ideally(kind, name) {
    const found = this.idealTurns?.done[0]?.[kind];
    if (!found) return null;
    const floor = 1e-9 * Math.max(...Object.values(found));
    return found[name] > floor ? found[name] : null;
  }
}
