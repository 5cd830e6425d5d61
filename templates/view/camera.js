const HINGE = [213, 94, 0];
const ANGLE = (26 * Math.PI) / 180; // of view, from top to bottom
const rgb = (text) => [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16));

/** Where the eye is, and how pointer, wheel, fingers and keys move it. Angles in degrees. */
class Camera {
  constructor(home, changed) {
    this.changed = changed;
    this.home = home;
    this.reset();
  }

  reset() {
    Object.assign(this, { azimuth: this.home.azimuth, elevation: this.home.elevation, zoom: 1, aside: [0, 0, 0], follow: [0, 0, 0] });
    this.changed();
  }

  turn(azimuth, elevation) {
    this.azimuth += azimuth;
    this.elevation = clamp(this.elevation + elevation, -89.9, 89.9);
    this.changed();
  }

  nearer(factor) {
    this.zoom = clamp(this.zoom * factor, 0.1, 60);
    this.changed();
  }

  /** Pixels of the page to the right and down */
  shift(x, y, height) {
    const [right, up] = axesOf(this);
    const metre = (2 * this.distance * Math.tan(ANGLE / 2)) / height;
    this.aside = plus(this.aside, plus(times(-x * metre, right), times(y * metre, up)));
    this.changed();
  }

  get distance() {
    return (this.fit * this.home.radius) / this.zoom;
  }

  /** What a painter needs. width, height: pixels of the picture */
  look(width, height, ratio) {
    const { radius, centre } = this.home;
    const aspect = width / height;
    this.fit = 1 / Math.sin(ANGLE / 2) / Math.min(1, aspect * 0.98);
    const [right, up, towards] = axesOf(this);
    const middle = plus(centre, this.follow);
    const target = plus(middle, this.aside);
    const eye = plus(target, times(this.distance, towards));
    const reach = this.distance + norm(this.aside);
    const view = product(
      perspective(ANGLE, aspect, Math.max(reach / 400, this.distance - 6 * radius - norm(this.aside)), reach + 12 * radius),
      lookAt(eye, right, up, towards),
    );
    const sun = unit(plus(plus(times(-0.5, axesOf({ azimuth: this.azimuth, elevation: 0 })[0]), times(0.42, axesOf({ azimuth: this.azimuth, elevation: 0 })[2])), [0, 0, 1.05]));
    return { view, eye, target: middle, radius, sun, ratio, axes: [right, up], metre: (2 * this.distance * Math.tan(ANGLE / 2)) / height };
  }

  /** Pointers: one turns, the right one, one with Shift, or two together shift, two apart come nearer */
  listen(element, keys) {
    const held = new Map();
    element.addEventListener("contextmenu", (event) => event.preventDefault());
    element.addEventListener("pointerdown", (event) => {
      element.setPointerCapture(event.pointerId);
      held.set(event.pointerId, event);
      element.classList.add("held");
    });
    const gone = (event) => {
      held.delete(event.pointerId);
      if (held.size === 0) element.classList.remove("held");
    };
    element.addEventListener("pointerup", gone);
    element.addEventListener("pointercancel", gone);
    element.addEventListener("pointermove", (event) => {
      const before = held.get(event.pointerId);
      if (before === undefined) return;
      const [x, y] = [event.clientX - before.clientX, event.clientY - before.clientY];
      const other = [...held.values()].find((each) => each.pointerId !== event.pointerId);
      held.set(event.pointerId, event);
      if (other !== undefined) {
        const gap = (a) => Math.hypot(a.clientX - other.clientX, a.clientY - other.clientY);
        this.shift(x / 2, y / 2, element.clientHeight);
        if (gap(before) > 0) this.nearer(gap(event) / gap(before));
      } else if (event.buttons & 2 || event.shiftKey) this.shift(x, y, element.clientHeight);
      else this.turn(-0.4 * x, 0.4 * y);
    });
    element.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.nearer(Math.exp(-clamp(event.deltaY * (event.deltaMode === 1 ? 16 : 1), -120, 120) * 0.0016));
    }, { passive: false });
    element.addEventListener("dblclick", () => this.reset());
    const own = {
      ArrowLeft: (e) => (e.shiftKey ? this.shift(-30, 0, element.clientHeight) : this.turn(-5, 0)),
      ArrowRight: (e) => (e.shiftKey ? this.shift(30, 0, element.clientHeight) : this.turn(5, 0)),
      ArrowUp: (e) => (e.shiftKey ? this.shift(0, -30, element.clientHeight) : this.turn(0, 5)),
      ArrowDown: (e) => (e.shiftKey ? this.shift(0, 30, element.clientHeight) : this.turn(0, -5)),
      "+": () => this.nearer(1.2),
      "=": () => this.nearer(1.2),
      "-": () => this.nearer(1 / 1.2),
      0: () => this.reset(),
      Home: () => this.reset(),
      ...keys,
    };
    element.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || !Object.hasOwn(own, event.key)) return;
      event.preventDefault();
      own[event.key](event);
    });
  }
}
