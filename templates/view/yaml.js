/** Plain data as YAML that lamc reads: names in double quotes, numbers with all their digits */
function yaml(value, indent = "") {
  const scalar = (x) => {
    if (typeof x === "string") return JSON.stringify(x);
    if (typeof x === "number" && !Number.isFinite(x)) return x > 0 ? ".inf" : "-.inf";
    return x === null ? "null" : String(x);
  };
  const isNested = (x) => x !== null && typeof x === "object" && Object.keys(x).length > 0;
  const empty = (x) => (Array.isArray(x) ? "[]" : "{}");
  const entry = (x) => {
    if (x === null || typeof x !== "object") return ` ${scalar(x)}`;
    if (!isNested(x)) return ` ${empty(x)}`;
    if (Array.isArray(x) && x.every((y) => y === null || typeof y !== "object")) return ` [${x.map(scalar).join(", ")}]`;
    return `\n${yaml(x, `${indent}  `)}`;
  };
  if (Array.isArray(value)) return value.map((x) => `${indent}-${entry(x)}`).join("\n");
  const key = (name) => (/^[A-Za-z_][\w-]*$/.test(name) && !/^(y|n|yes|no|on|off|true|false|null)$/i.test(name) ? name : JSON.stringify(name));
  return Object.entries(value).map(([name, x]) => `${indent}${key(name)}:${entry(x)}`).join("\n");
}

/** What was changed on a page, as a scene for `lamc run FILE --scene`; parameters belong to no scene, so they are told
 * as options */
function sceneText(base, { angles, inputs, parameters }) {
  const scene = { ...base };
  if (Object.keys(angles).length > 0) {
    scene.angles = { ...scene.angles, ...angles };
    delete scene.branch; // of the position that it left
  }
  if (Object.keys(inputs).length > 0) {
    const as = (old, value) => (old !== null && typeof old === "object" ? { ...old, default: value } : value);
    scene.inputs = { ...scene.inputs };
    for (const [name, value] of Object.entries(inputs)) scene.inputs[name] = as(scene.inputs[name], value);
  }
  const quoted = (text) => `'${text.replaceAll("'", "'\\''")}'`;
  const options = Object.entries(parameters).map(([name, value]) => ` --set ${quoted(`${name}=${value}`)}`);
  const lines = options.length === 0 ? [] : [`# with${options.join("")}`.replace(/[\r\n]/g, " ")];
  return [...lines, "kind: scene", yaml(scene), ""].join("\n");
}
