/**
 * Bodies -> a 3MF file: a ZIP archive, not packed, with an object and an item a body, its name, and the unit. Coordinates have nine
 * digits, which is all of an f32. Source: 3MF Core Specification 1.3; APPNOTE.TXT of ZIP, 4.3.
 */

/** Units, and their names in a 3MF, which Open CASCADE has, too. @type {Record<string, string>} */
export const UNITS = { mm: 'millimeter', cm: 'centimeter', m: 'meter', in: 'inch', ft: 'foot' };
/** Bytes of text that are encoded at once. */
const PIECE = 1 << 20;

const CORE = 'http://schemas.microsoft.com/3dmanufacturing';
const PACKAGE = 'http://schemas.openxmlformats.org/package/2006';
const XML = '<?xml version="1.0" encoding="UTF-8"?>\n';
const TYPES = `${XML}<Types xmlns="${PACKAGE}/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>`;
const RELATIONS = `${XML}<Relationships xmlns="${PACKAGE}/relationships"><Relationship Target="/3D/3dmodel.model" Id="model" Type="${CORE}/2013/01/3dmodel"/></Relationships>`;

/** @typedef {import('./bodies.js').Body} Body @typedef {Uint8Array<ArrayBuffer>} Bytes */

/** The bytes of the file, in pieces. @param {Body[]} bodies @param {string} unit @returns {Bytes[]} */
export function threeMf(bodies, unit) {
  return zip([
    ['[Content_Types].xml', [encoded(TYPES)]],
    ['_rels/.rels', [encoded(RELATIONS)]],
    ['3D/3dmodel.model', [...model(bodies, UNITS[unit])]],
  ]);
}

/** The model as XML, in pieces. @param {Body[]} bodies @param {string} unit */
function* model(bodies, unit) {
  let text = `${XML}<model unit="${unit}" xmlns="${CORE}/core/2015/02"><resources>\n`;
  for (const [at, { name, positions, index }] of bodies.entries()) {
    text += `<object id="${at + 1}" name="${escaped(name)}" type="model"><mesh><vertices>\n`;
    for (let i = 0; i < positions.length; i += 3) {
      text += `<vertex x="${digits(positions[i])}" y="${digits(positions[i + 1])}" z="${digits(positions[i + 2])}"/>\n`;
      if (text.length > PIECE) yield encoded(text);
      if (text.length > PIECE) text = '';
    }
    text += '</vertices><triangles>\n';
    for (let i = 0; i < index.length; i += 3) {
      text += `<triangle v1="${index[i]}" v2="${index[i + 1]}" v3="${index[i + 2]}"/>\n`;
      if (text.length > PIECE) yield encoded(text);
      if (text.length > PIECE) text = '';
    }
    text += '</triangles></mesh></object>\n';
  }
  const items = bodies.map((_, at) => `<item objectid="${at + 1}"/>`).join('');
  yield encoded(`${text}</resources><build>${items}</build></model>\n`);
}

/** @param {number} number */
function digits(number) {
  return String(Number(number.toPrecision(9)));
}

/** @param {string} text */
function escaped(text) {
  return text.replace(/[&<>"]/g, (letter) => `&#${letter.charCodeAt(0)};`);
}

/** @param {string} text @returns {Bytes} */
function encoded(text) {
  return new TextEncoder().encode(text);
}

/** An archive of files that are not packed. @param {[string, Bytes[]][]} files @returns {Bytes[]} */
function zip(files) {
  /** @type {Bytes[]} */
  const made = [];
  /** @type {Bytes[]} */
  const listed = [];
  let offset = 0;
  for (const [name, pieces] of files) {
    const bytes = encoded(name);
    const size = pieces.reduce((sum, piece) => sum + piece.length, 0);
    if (size > 0xffffffff) throw new RangeError(`the triangles take ${size} bytes as 3MF, and a ZIP archive holds 4294967295`);
    // version 2.0, and the first day that there is
    const facts = [...u16(20, 0, 0, 0, 0x21), ...u32(crc32(pieces), size, size), ...u16(bytes.length, 0)];
    made.push(Uint8Array.from([...u32(0x04034b50), ...facts]), bytes, ...pieces);
    listed.push(Uint8Array.from([...u32(0x02014b50), ...u16(20), ...facts, ...u16(0, 0, 0), ...u32(0, offset)]), bytes);
    offset += 30 + bytes.length + size;
  }
  const n_listed = listed.reduce((sum, piece) => sum + piece.length, 0);
  const end = [...u32(0x06054b50), ...u16(0, 0, files.length, files.length), ...u32(n_listed, offset), ...u16(0)];
  return [...made, ...listed, Uint8Array.from(end)];
}

/** Numbers of two bytes each, the lower first. @param {...number} numbers */
function u16(...numbers) {
  return numbers.flatMap((number) => [number & 255, number >>> 8]);
}

/** Numbers of four bytes each, the lowest first. @param {...number} numbers */
function u32(...numbers) {
  return numbers.flatMap((number) => u16(number & 0xffff, number >>> 16));
}

/** @type {Uint32Array | undefined} */
let table;

/** The check sum of a ZIP archive. @param {Uint8Array[]} pieces */
function crc32(pieces) {
  table ??= Uint32Array.from({ length: 256 }, (_, byte) => {
    let sum = byte;
    for (let bit = 0; bit < 8; bit += 1) sum = sum & 1 ? (sum >>> 1) ^ 0xedb88320 : sum >>> 1;
    return sum;
  });
  let sum = 0xffffffff;
  for (const piece of pieces) for (let at = 0; at < piece.length; at += 1) sum = table[(sum ^ piece[at]) & 255] ^ (sum >>> 8);
  return (sum ^ 0xffffffff) >>> 0;
}
