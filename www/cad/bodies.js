/**
 * What Open CASCADE read of a file -> bodies, each with a name, a colour and its triangles. The tree of an assembly becomes names: the
 * names on the way to a body, separated by slashes.
 */

/**
 * @typedef {{ name: string, meshes: number[], children: Node[] }} Node a part of an assembly, or a shape with its bodies
 * @typedef {[number, number, number]} Rgb linear shares, 0 to 1
 * @typedef {object} Mesh a body
 * @property {string} name
 * @property {Rgb} [color]
 * @property {{ first: number, last: number, color: Rgb | null }[]} brep_faces
 * @property {{ position: { array: number[] } }} attributes three numbers a vertex
 * @property {{ array: number[] }} index three vertices a triangle
 * @typedef {{ success: boolean, root?: Node, meshes?: Mesh[] }} Read what occt-import-js returns
 * @typedef {{ name: string, colour: string | null, positions: number[], index: number[] }} Body
 */

/** Bodies of a file, in its order; a body without triangles is left out. @param {Read} read @returns {Body[]} */
export function bodiesOf({ root, meshes = [] }) {
  /** @type {Body[]} */
  const bodies = [];
  const names = new Names();
  const visit = (/** @type {Node} */ node, /** @type {string[]} */ path) => {
    const here = node.name ? [...path, node.name] : path;
    for (const at of node.meshes) {
      const { name, attributes, index, ...colours } = meshes[at];
      if (index.array.length === 0) continue;
      // a shape of one body has its name
      const full = name && name !== here.at(-1) ? [...here, name] : here;
      bodies.push({
        name: names.take(full.map(plain).filter(Boolean).join('/') || 'body'),
        colour: colourOf(colours),
        positions: attributes.position.array,
        index: index.array,
      });
    }
    for (const child of node.children) visit(child, here);
  };
  if (root) visit(root, []);
  return bodies;
}

/** Gives each body a name of its own: the second `nut` is `nut 2`. */
class Names {
  /** @type {Map<string, number>} */
  #times = new Map();

  /** @param {string} name */
  take(name) {
    const times = (this.#times.get(name) ?? 0) + 1;
    this.#times.set(name, times);
    return times === 1 ? name : `${name} ${times}`;
  }
}

/** A name without what separates the settings of a file on the command line, or cannot be shown. @param {string} name */
function plain(name) {
  return name
    .replace(/[\s\p{Cc}\p{Cs},:/]+/gu, ' ')
    .trim()
    .slice(0, 100);
}

/** The colour of a body, or that of its faces where all have the same. @param {Pick<Mesh, 'color' | 'brep_faces'>} mesh */
function colourOf({ color, brep_faces: faces }) {
  if (color) return hex(color);
  const [first, ...others] = new Set(faces.map((face) => (face.color ? hex(face.color) : null)));
  return others.length === 0 ? (first ?? null) : null;
}

/** As #rrggbb: Open CASCADE holds linear shares of light, files and screens those of sRGB. @param {Rgb} colour */
function hex(colour) {
  const bytes = colour.map((share) =>
    Math.round(255 * (share <= 0.0031308 ? 12.92 * share : 1.055 * share ** (1 / 2.4) - 0.055)),
  );
  return `#${bytes.map((byte) => Math.min(Math.max(byte, 0), 255).toString(16).padStart(2, '0')).join('')}`;
}

/** The box around all bodies: the least coordinates, then the largest. @param {Body[]} bodies */
export function boxOf(bodies) {
  const box = [Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity];
  for (const { positions } of bodies) {
    for (let at = 0; at < positions.length; at += 1) {
      const axis = at % 3;
      if (positions[at] < box[axis]) box[axis] = positions[at];
      if (positions[at] > box[3 + axis]) box[3 + axis] = positions[at];
    }
  }
  return box;
}
