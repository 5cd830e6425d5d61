/** An element with properties and children; text stays text, whatever the names of a design are */
function el(kind, properties = {}, ...children) {
  const element = document.createElement(kind);
  for (const [name, value] of Object.entries(properties)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name in element && name !== "list" && name !== "role") element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

const svg = (kind, properties = {}, ...children) => {
  const element = document.createElementNS("http://www.w3.org/2000/svg", kind);
  for (const [name, value] of Object.entries(properties)) element.setAttribute(name, value);
  element.append(...children);
  return element;
};
const short = (name, most = 28) => (name.length > most ? `${name.slice(0, most - 1)}…` : name);
const isDark = () => window.matchMedia("(prefers-color-scheme: dark)").matches;
const MOST_RATIO = 2; // pixels of a picture by one of the page: finer screens cost time and show nothing more
const ratioOf = () => clamp(window.devicePixelRatio || 1, 1, MOST_RATIO);

/** Gives a canvas the size that it has on the page; true where that changed */
function fitted(canvas) {
  const ratio = ratioOf();
  const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((x) => Math.max(1, Math.round(x * ratio)));
  if (canvas.width === width && canvas.height === height) return false;
  [canvas.width, canvas.height] = [width, height];
  return true;
}

/** Once per frame of the browser, however often it is asked for */
function perFrame(work) {
  let waits = false;
  return () => {
    if (waits) return;
    waits = true;
    requestAnimationFrame(() => {
      waits = false;
      work();
    });
  };
}
