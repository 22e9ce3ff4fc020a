/** What a mesh found, as sentences with places, and what helps. */
import { count, measure, roughly } from './format.js';
import { rounded, sentence } from './messages.js';
import { many, placeText } from './places.js';
import { removeGeometry } from './files.js';
import { joinPatches } from './patches.js';
import { change, isSame, set, state } from './state.js';

/** @typedef {import('hexcast').Report} Report @typedef {import('hexcast').Leak} Leak */

/**
 * A finding.
 *
 * @typedef {object} Finding
 * @property {'open' | 'thin' | 'overlap' | 'empty' | 'shells' | 'leak'} kind
 * @property {string} subject whose place is shown, for the button
 * @property {string} text a sentence or more
 * @property {number[] | null} place in world lengths; null where it has none in the mesh
 * @property {import('./messages.js').Remedy} [remedy] what helps
 */

/** Starts of the warnings that findings stand for, and of the one that the head of the page does, unless a device was lost meanwhile. */
const ON_CPU = /^meshed on the CPU: (?!the GPU device was lost)/;
const THIN = /^geometry "(.*)" has walls of fewer than \d+ cells along/;
const OPEN = /^geometry "(.*)" is not closed/;
const SHELLS = /^shells of geometry "(.*)" overlap/;
const EMPTY = /^geometry "(.*)" \(flag (\d+)\) got no cell: (.*)$/s;

/**
 * All findings of a report, and that of a leak. A column file holds none of the report.
 *
 * @param {Report} report
 * @param {Leak | null} leak
 * @returns {Finding[]}
 */
export function findingsOf(report, leak) {
  const { certificate } = report;
  return [
    ...(report.open ?? []).map((open) => ofOpen(open, report)),
    ...report.warnings.flatMap((warning) => [...ofEmpty(warning, report), ...ofShells(warning)]),
    ...(certificate?.thin_walls ?? []).map((wall) => ofThin(wall, report)),
    ...(certificate?.overlaps ?? []).map((overlap) => ofOverlap(overlap, report)),
    ...(leak?.narrowest ? [ofLeak(leak.narrowest, leak, report)] : []),
  ];
}

/** The warnings of a report without those that findings, or the name of the device, stand for. @param {Report} report */
export function otherWarnings({ warnings }) {
  return warnings.filter((warning) => ![ON_CPU, THIN, OPEN, EMPTY, SHELLS].some((start) => start.test(warning)));
}

/** @param {import('hexcast').OpenReport} open @param {Report} report @returns {Finding} */
function ofOpen(open, { cells, ...report }) {
  const { geometry, policy, open_edges: edges, holes, added_facets: n, longest_at: place, doubtful_cells: doubtful } = open;
  const added = n ? ` ${many(n, 'missing facet')} ${n === 1 ? 'was' : 'were'} added.` : '';
  const facts = `${geometry} is not closed: ${many(edges, 'open edge')} in ${many(holes, 'loop')}, the longest edge at ${placeText(place, report)}.${added}`;
  const decided = policy === 'vote' ? 'most of their even rays' : 'the winding number';
  const share = `${count(doubtful)} of ${roughly(cells)} cells ${doubtful === 1 ? 'was' : 'were'} doubtful`;
  const patches = state.patches?.find(({ name }) => name === geometry) && state.patches;
  if (patches) {
    const others = patches.filter(({ name }) => name !== geometry).map(({ name }) => name);
    const text = `${facts} With ${others.join(' and ')} it is one closed surface, of which it is a part.`;
    return {
      kind: 'open',
      subject: `the edge of ${geometry}`,
      text,
      place,
      remedy: { label: 'Join the parts', act: joinPatches },
    };
  }
  const text = doubtful === 0 ? `${facts} No cell was doubtful.` : `${facts} ${share}: ${decided} decided.`;
  return { kind: 'open', subject: `the edge of ${geometry}`, text, place };
}

/** @param {import('hexcast').CertificateReport['thin_walls'][number]} wall @param {Report} report @returns {Finding} */
function ofThin({ geometry, axis, rays, lost, cells, place }, { certificate, filled, ...report }) {
  const facts = `${geometry} has walls of fewer than ${certificate?.thin_cells} cells along ${axis}: ${many(rays, 'ray segment')}, the thinnest of ${many(cells, 'cell')} at ${placeText(place, report)}.`;
  const isKept = filled?.some((entry) => entry.geometry === geometry);
  const loss =
    lost > 0
      ? ` ${count(lost)} of them hold no centre of a cell${isKept ? '; its fill keeps the wall' : ': the wall has holes there'}.`
      : '';
  const remedy = lost > 0 && !isKept ? { label: 'Keep thin walls', act: () => set({ fill: 'separating' }) } : undefined;
  return { kind: 'thin', subject: `the thin wall of ${geometry} along ${axis}`, text: facts + loss, place, remedy };
}

/** @param {import('hexcast').CertificateReport['overlaps'][number]} overlap @param {Report} report @returns {Finding} */
function ofOverlap({ winner, loser, cells, volume, place }, { unit }) {
  const text = `${winner} and ${loser} overlap in ${many(cells, 'cell')}, a volume of ${measure(volume, unit, 3)}: ${winner} has them.`;
  return { kind: 'overlap', subject: `the overlap of ${winner} and ${loser}`, text, place };
}

/** @param {string} warning @param {Report} report @returns {Finding[]} */
function ofEmpty(warning, report) {
  const [, name, number, cause] = EMPTY.exec(warning) ?? [];
  if (name === undefined) return [];
  const flag = Number(number);
  const box = report.geometries?.find((geometry) => geometry.name === name && geometry.flag === flag)?.bounding_box;
  const place = box ? box[0].map((low, axis) => (low + box[1][axis]) / 2) : null;
  const mine = state.geometries.find((geometry) => geometry.flag === flag);
  const same = mine && state.geometries.find((other) => other !== mine && isSame(other, mine));
  const text = `${name} (flag ${flag}) has no cell: `;
  if (mine && same) {
    const remedy = { label: 'Remove it', act: () => removeGeometry(mine.id) };
    return [
      {
        kind: 'empty',
        subject: name,
        text: `${text}${same.source.name} is on the page twice, and the later wins.`,
        place,
        remedy,
      },
    ];
  }
  const winner = /^its cells are those of ".*" \(flag (\d+)\)/.exec(cause)?.[1];
  const remedy = mine && winner ? { label: 'Let it win', act: () => letWin(mine.id, Number(winner)) } : undefined;
  return [{ kind: 'empty', subject: name, text: `${text}${rounded(cause)}.`, place, remedy }];
}

/** Gives a geometry a higher priority than those of a flag. @param {number} id @param {number} flag */
function letWin(id, flag) {
  const others = state.geometries.filter((geometry) => geometry.flag === flag).map(({ priority }) => priority);
  const priority = Math.max(0, ...others) + 1;
  const geometries = state.geometries.map((geometry) => (geometry.id === id ? { ...geometry, priority } : geometry));
  change('geometries', { geometries, revision: state.revision + 1 });
}

/** @param {string} warning @returns {Finding[]} */
function ofShells(warning) {
  const name = SHELLS.exec(warning)?.[1];
  if (name === undefined) return [];
  const remedy = { label: 'Use the winding number', act: () => set({ rule: 'nonzero' }) };
  return [{ kind: 'shells', subject: `shells of ${name}`, text: sentence(warning), place: null, remedy }];
}

/** @param {NonNullable<Leak['narrowest']>} narrowest @param {Leak} leak @param {Report} report @returns {Finding} */
function ofLeak({ width, centre }, { facets }, report) {
  const of = facets && facets.length > 0 ? ` ${many(facets.length, 'facet')} of ${namesOf(facets)} lie around it.` : '';
  const text = `The leak is narrowest at ${placeText(centre, report)}: a cube of ${many(width, 'cell')} passes, none of ${width + 1}.${of}`;
  return { kind: 'leak', subject: 'the narrowest place of the leak', text, place: centre };
}

/** @param {{ geometry: string }[]} facets */
function namesOf(facets) {
  return [...new Set(facets.map(({ geometry }) => geometry))].join(' and ');
}
