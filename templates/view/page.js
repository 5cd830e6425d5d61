const SPEEDS = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100];

/** The clock of all shows of a page, and what drives it */
class Player {
  constructor(duration, speed) {
    Object.assign(this, { shows: [], duration, time: 0, playing: false, loops: true, driving: false });
    this.button = el("button", { type: "button", className: "play", title: "Play or pause (space)", onclick: () => this.play(!this.playing) });
    this.bar = el("input", { type: "range", min: "0", max: String(duration), step: "any", value: "0", "aria-label": "time, s" });
    this.bar.addEventListener("input", () => this.seek(Number(this.bar.value)));
    this.ticks = el("div", { className: "ticks" });
    this.told = el("output", { className: "time" });
    const nearest = SPEEDS.reduce((best, s) => (Math.abs(Math.log(s / speed)) < Math.abs(Math.log(best / speed)) ? s : best));
    this.rate = el("select", { "aria-label": "speed" }, ...SPEEDS.map((s) => el("option", { value: String(s), textContent: s === 1 ? "real time" : s < 1 ? `1/${Math.round(1 / s)}` : `${s} ×`, selected: s === nearest })));
    this.loop = el("input", { type: "checkbox", checked: true, onchange: () => (this.loops = this.loop.checked) });
    this.element = el(
      "div", { className: "player", role: "group", "aria-label": "playback" },
      this.button, el("div", { className: "track" }, this.bar, this.ticks), this.told,
      el("label", { className: "speed" }, el("span", { className: "wide", textContent: "speed " }), this.rate), el("label", { className: "wide" }, this.loop, " loop"),
    );
    this.play(false);
  }

  add(show) {
    this.shows.push(show);
  }

  get step() {
    return this.duration / 100;
  }

  refresh() {
    const places = new Set();
    const events = this.shows.flatMap((show) => show.events ?? []).filter(([t]) => {
      const place = Math.round((400 * t) / this.duration);
      return !places.has(place) && places.add(place);
    });
    this.ticks.replaceChildren(...events.map(([t, name]) => {
      const tick = el("i", { title: `${name}, t = ${Number(t.toPrecision(4))} s` });
      tick.style.left = `${(100 * t) / this.duration}%`;
      return tick;
    }));
  }

  /** Models of the page run on, or what was recorded plays */
  drive(on) {
    this.driving = on;
    this.shows.filter((show) => show.engine).forEach((show) => show.drive(on));
    this.end = on ? 0 : this.duration;
    this.bar.max = String(this.duration);
    this.seek(0);
  }

  advance(seconds) {
    const fine = this.shows.map((show) => show.advance?.(seconds) ?? true).every(Boolean);
    this.end = Math.max(...this.shows.map((show) => show.driver?.t ?? 0));
    this.bar.max = String(Math.max(this.end, 1e-9));
    this.seek(this.end);
    if (!fine) this.play(false);
  }

  seek(time) {
    this.time = clamp(time, 0, this.driving ? this.end : this.duration);
    this.bar.value = String(this.time);
    this.told.textContent = this.shows.every((show) => show.tellTime) ? this.shows[0].tellTime(this.time) : `${fixed(this.time, this.duration / 1000)} s`;
    this.shows.forEach((show) => show.seek(this.time));
  }

  play(wanted) {
    this.playing = wanted;
    this.button.textContent = wanted ? "❚❚" : "▶";
    this.button.setAttribute("aria-label", wanted ? "Pause" : "Play");
    if (!wanted) return;
    if (!this.driving && this.time >= this.duration) this.time = 0;
    let last = performance.now();
    const frame = (now) => {
      if (!this.playing) return;
      const passed = clamp((now - last) / 1e3, 0, 0.1); // after a pause of the browser's it goes on, it does not jump
      last = now;
      if (this.driving) {
        this.advance(Math.min(passed, 0.05) * Number(this.rate.value));
        if (this.playing) requestAnimationFrame(frame);
        return;
      }
      let next = this.time + passed * Number(this.rate.value);
      if (next >= this.duration) {
        next = this.loops ? next % this.duration : this.duration;
        if (!this.loops) this.play(false);
      }
      this.seek(next);
      if (this.playing) requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }
}

const KINDS = { device: (data, player) => (data.live ? new LiveDevice(data, player) : new Device(data, player)), plate: (data, player) => new Plate(data, player) };

async function main() {
  const data = await unpacked(document.getElementById("data").textContent);
  const moving = data.shows.filter((show) => show.duration > 0);
  const player = new Player(Math.max(...moving.map((show) => show.duration), 1e-9), Math.min(...moving.map((show) => show.speed), 1e3));
  const shows = data.shows.map((show) => KINDS[show.kind](show, player));
  shows.forEach((show) => player.add(show));
  const root = document.getElementById("root");
  root.dataset.count = String(shows.length);
  root.replaceChildren(...shows.map((show) => show.element));
  player.element.classList.toggle("timeless", shows.every((show) => show.tellTime));
  if (moving.length > 0) document.getElementById("bar").replaceChildren(player.element);
  player.refresh();
  const keys = { " ": () => player.play(!player.playing), ",": () => player.seek(player.time - player.step), ".": () => player.seek(player.time + player.step) };
  shows.forEach((show) => show.stage.camera.listen(show.stage.canvas, keys));
  globalThis.lamcView = { data, shows, player }; // for tests, and for who is curious
  player.seek(0);
  for (const show of shows) {
    if (!show.enliven) continue;
    const source = document.getElementById(`engine-${show.data.live.engine}`).textContent + document.getElementById("serving").textContent;
    try {
      await show.enliven(globalThis.lamcEngines[show.data.live.engine], source);
    } catch (error) {
      show.tell(`The model in this page cannot run here (${error.message}); what was recorded plays.`);
    }
  }
  document.getElementById("tools").replaceChildren(...tools(shows, player));
  const drives = shows.every((show) => show.engine && show.recorded === null);
  if (drives) player.drive(true);
  const at = new URLSearchParams(location.hash.slice(1)).get("t"); // FILE.html#t=1.5 shows that instant, at rest
  if (at !== null) {
    if (drives) player.advance(Number(at));
    player.seek(Number(at));
  } else if (moving.length > 0 && !window.matchMedia("(prefers-reduced-motion: reduce)").matches) player.play(true);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => player.seek(player.time));
  document.body.dataset.ready = "yes";
}

/** Buttons for all pictures of the page */
function tools(shows, player) {
  const made = [];
  const devices = shows.filter((show) => show.data.hinges?.length > 0);
  const toggle = (text, on, change) => {
    const box = el("input", { type: "checkbox", checked: on, onchange: () => change(box.checked) });
    return el("label", {}, box, ` ${text}`);
  };
  if (devices.length > 0) made.push(toggle("names", false, (on) => devices.forEach((show) => show.stage.name(on))));
  if (devices.some((show) => show.stage.home.wanders)) {
    made.push(toggle("follow", true, (on) => devices.forEach((show) => {
      show.stage.follows = on && show.stage.home.wanders;
      player.seek(player.time);
    })));
  }
  if (shows.some((show) => show.engine)) {
    const drives = shows.every((show) => show.engine && show.recorded === null);
    const drive = toggle("drive", drives, (on) => {
      player.drive(on);
      player.play(true);
    });
    drive.title = "The model begins anew and runs on, and sliders act at once";
    made.push(drive);
  }
  made.push(el("button", { type: "button", textContent: "Reset view", onclick: () => shows.forEach((show) => show.stage.camera.reset()) }));
  return made;
}

main().catch((error) => {
  document.getElementById("root").replaceChildren(el("p", { className: "problem", textContent: `This page cannot be shown: ${error.message}` }));
  document.body.dataset.ready = "no";
});
