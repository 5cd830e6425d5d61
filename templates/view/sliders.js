/**
 * A labelled slider with a field for the number beside it. member: { name, title, value, least, most, log, factor, unit };
 * value, least and most in SI, factor to what is shown. moved(value, done): done is false while one drags.
 */
class Slider {
  constructor(member, moved) {
    Object.assign(this, { factor: 1, unit: "", log: false, ...member });
    this.start = this.value;
    this.moved = moved;
    const label = `${this.name}${this.unit ? `, ${this.unit}` : ""}`;
    this.bar = el("input", { type: "range", min: "0", max: "1000", step: "any", "aria-label": label });
    this.field = el("input", { type: "number", step: "any", "aria-label": label, title: this.title ?? "" });
    this.wrong = el("output", { className: "wrong" });
    const head = el("span", { className: "name", title: this.title ?? this.name }, short(this.name, 34));
    this.element = el("div", { className: "slider" }, head, this.bar, this.field, el("span", { className: "unit", textContent: this.unit }), this.wrong);
    this.bar.addEventListener("input", () => this.take(this.fromBar(), false));
    this.bar.addEventListener("change", () => this.take(this.fromBar(), true));
    this.field.addEventListener("change", () => {
      if (Number.isFinite(this.field.valueAsNumber)) this.take(this.field.valueAsNumber / this.factor, true);
      else this.put(this.value);
    });
    head.addEventListener("dblclick", () => this.take(this.start, true));
    this.put(this.value);
  }

  fromBar() {
    const share = Number(this.bar.value) / 1000;
    const value = this.log ? this.least * (this.most / this.least) ** share : this.least + share * (this.most - this.least);
    return Number(value.toPrecision(5));
  }

  take(value, done) {
    this.put(value);
    this.wrong.textContent = "";
    this.moved(value, done);
  }

  /** Shows a value without telling anybody */
  put(value) {
    this.value = value;
    const within = clamp(value, this.least, this.most);
    const share = this.log ? Math.log(within / this.least) / Math.log(this.most / this.least) : (within - this.least) / (this.most - this.least);
    this.bar.value = String(1000 * share);
    const shown = Number((value * this.factor).toPrecision(6));
    const text = String(this.unit === "°" && Math.abs(shown) < 1e-9 ? 0 : shown); // round-off of closing loops
    if (document.activeElement !== this.field || Number(this.field.value) !== Number(text)) this.field.value = text;
    this.element.classList.toggle("changed", value !== this.start);
  }

  refuse(text) {
    this.wrong.textContent = text;
  }
}

/** How far a slider of a number goes: a tenth to ten times what is above zero, twice what is not, and its bounds; scale:
 * what is much for such a number, where it is zero */
function rangeOf({ value, least, most, scale }) {
  const [low, high] = [least ?? -Infinity, most ?? Infinity];
  if (low >= 0 && value > 0) {
    const [a, b] = [Math.max(low, value / 10), Math.min(high, value * 10)];
    return { least: a > 0 ? a : value / 10, most: b, log: b / (a > 0 ? a : value / 10) > 4 };
  }
  const span = value !== 0 ? 2 * Math.abs(value) : (scale ?? 1);
  return { least: Math.max(low, Math.min(-span, 0)), most: Math.min(high, span), log: false };
}

/** One slider that turns all of a group by a factor, where they are alike and many */
function together(sliders, moved) {
  const own = sliders.map((slider) => slider.start);
  if (sliders.length < 3 || own.some((value) => value === 0)) return null;
  return new Slider({ name: `all ${sliders.length}, times`, title: "a factor for all of them", value: 1, least: 0.1, most: 10, log: true }, (factor, done) => {
    sliders.forEach((slider, k) => slider.put(own[k] * factor));
    moved(sliders, done);
  });
}

/** Sliders under a heading that opens and closes; a field to find them by name where they are many */
function group(title, sliders, open) {
  const body = el("div", { className: "group" }, ...sliders.map((slider) => slider.element));
  const many = sliders.filter((slider) => !slider.isAll);
  if (many.length > 12) {
    const find = el("input", { type: "search", placeholder: "find by name", "aria-label": `find in ${title}` });
    find.addEventListener("input", () => {
      const text = find.value.toLowerCase();
      many.forEach((slider) => (slider.element.hidden = !slider.name.toLowerCase().includes(text)));
    });
    body.prepend(find);
  }
  return el("details", { open }, el("summary", {}, title, el("span", { className: "count", textContent: String(many.length) })), body);
}
