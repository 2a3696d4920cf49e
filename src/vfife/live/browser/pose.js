// Positions of pins and angles of bodies at a moment, interpolated between two outputs.
class Pose {
  constructor(reader, data, from, to = from, share = 0) {
    Object.assign(this, { reader, data, from, to, share });
  }

  static at({ reader, store }, head) {
    if (!store.end) return null;
    const low = Math.min(Math.max(Math.floor(head), store.begin), store.end - 1);
    const high = Math.min(low + 1, store.end - 1);
    return new Pose(reader, store.data, store.offset(low), store.offset(high), Math.min(Math.max(head - low, 0), 1));
  }

  place([p, px, py]) {
    const [x, y, angle] = this.reader.particle(this.data, this.from, this.to, this.share, p);
    if (px === 0 && py === 0) return [x, y];
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    return [x + c * px - s * py, y + s * px + c * py];
  }

  angle(p) {
    return this.reader.particle(this.data, this.from, this.to, this.share, p)[2];
  }
}
