// A box of 4 x 2 x 2 as an ASCII STL, whole and without its upper side, z = 2.

/** Facets without the upper side; bit 0 of a corner's number is its end along x, bit 1 along y, bit 2 along z. */
const SIDES = ['023', '031', '015', '054', '267', '273', '046', '062', '137', '175'];

export const OPEN_BOX = stl(SIDES);
export const CLOSED_BOX = boxBetween([0, 0, 0], [4, 2, 2]);

/** What the open box lacks. */
export const LID = stl(['457', '476']);

/** A whole box between two corners. @param {number[]} low @param {number[]} high */
export function boxBetween(low, high) {
  return stl([...SIDES, '457', '476'], low, high);
}

/** @param {string[]} facets */
function stl(facets, low = [0, 0, 0], high = [4, 2, 2]) {
  const corner = (number) => `vertex ${[0, 1, 2].map((axis) => ((number >> axis) & 1 ? high : low)[axis]).join(' ')}`;
  const facet = (corners) =>
    `facet normal 0 0 0\nouter loop\n${[...corners].map((digit) => corner(Number(digit))).join('\n')}\nendloop\nendfacet`;
  return `solid box\n${facets.map(facet).join('\n')}\nendsolid box\n`;
}
