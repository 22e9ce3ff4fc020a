/** The problems of a mesh: the findings of its report, overlaps of its certificate, and a leak; each in words, with a place and what helps. */
import { measure } from '../text/format.js';
import { sentence } from '../elements/messages.js';
import { many, placeText } from '../text/places.js';
import { joinPatches } from '../geometries/patches.js';
import { remediesOf, remedyOf } from './remedies.js';
import { isSame, state } from '../state/state.js';

/** @typedef {import('hexcast').Report} Report @typedef {import('hexcast').Leak} Leak @typedef {import('../state/state.js').Finding} Finding */

/** What each finding is in a few words; $ is the part. @type {Record<import('../state/state.js').Finding['kind'], string>} */
const TITLES = {
  'gpu-failed': 'The GPU failed',
  'file-changed': 'A file was not read as it stands',
  'end-without-line': '$ ends between two lines',
  'edge-on-line': 'A line lies on an edge of $',
  'unit-differs': 'A file has another unit',
  'fluid-without-geometry': 'No part is the fluid',
  'conductor-thin': 'Metal is half a cell too thin',
  'cells-fine': 'Cells are far smaller than asked for',
  'surface-open': '$ is not closed',
  'rays-odd': 'A surface is not closed',
  'surface-open-parity': '$ is not closed',
  'surface-inside-out': '$ is inside out',
  'flag-shared': '$ has the flag of another part',
  'shells-overlap': 'Shells of $ overlap',
  'shell-lost': 'Shells of $ without cells',
  'volume-off': 'Volume of $ is off',
  'volume-filled': 'Cells of $ are too thick',
  'wall-thin': 'Thin walls in $',
  'gap-narrow': 'A gap is one cell wide',
  'no-cell-outside': 'No cells for $',
  'no-cell-no-area': 'No cells for $',
  'no-cell-thin': 'No cells for $',
  'no-cell-flat': 'No cells for $',
  'no-cell-open': 'No cells for $',
  'no-cell-small': 'No cells for $',
  'no-cell-covered': 'No cells for $',
  'plate-covered': 'Faces of $ are covered',
  overlap: 'Two parts overlap',
  leak: 'There is a leak',
};

/**
 * All findings of a report, and that of a leak. A column file holds none of the report; what meshed is said at the head of the page.
 *
 * @param {Report} report
 * @param {Leak | null} leak
 * @returns {Finding[]}
 */
export function findingsOf(report, leak) {
  return [
    ...withOffersFirst(report.findings.map((finding) => ofReport(finding, report))),
    ...(report.certificate?.overlaps ?? []).map((overlap) => ofOverlap(overlap, report)),
    ...(leak?.narrowest ? [ofLeak(leak.narrowest, leak, report)] : []),
  ];
}

/** @param {Finding[]} findings */
function withOffersFirst(findings) {
  const has = (/** @type {Finding} */ { remedies }) => remedies.length > 0;
  return [...findings.filter(has), ...findings.filter((finding) => !has(finding))];
}

/** @param {import('hexcast').Finding} finding @param {Report} report @returns {Finding} */
function ofReport(finding, { geometries }) {
  const { code, geometry, axis, points, boxes } = finding;
  const subject = `${geometry?.name ?? 'the mesh'}${axis ? ` along ${axis}` : ''}`;
  const box = boxes[0] ?? (geometry && geometries?.[geometry.index]?.bounding_box);
  const place = points[0] ?? (box ? box[0].map((low, axis) => (low + box[1][axis]) / 2) : null);
  const known = fromPage(finding);
  const text = [sentence(finding.sentence), ...(known ? [known.text] : [])].join(' ');
  const title = TITLES[code].replace('$', () => geometry?.name ?? 'a part');
  const flag = finding.flag ?? null;
  const remedies = known ? [known.remedy] : remediesOf(finding);
  return { kind: code, subject, title, text, place, boxes: boxes.map((ends) => ends.flat()), flag, remedies };
}

/** What only the page knows of a finding, as it has the files. @param {import('hexcast').Finding} finding */
function fromPage({ code, geometry, flag }) {
  const { geometries, patches, job } = state;
  if (code === 'surface-open' && patches?.some(({ name }) => name === geometry?.name)) {
    const others = patches.filter(({ name }) => name !== geometry?.name).map(({ name }) => name);
    const text = `With ${others.join(' and ')} it is one closed surface, of which it is a part.`;
    return { text, remedy: { label: 'Join the parts', act: joinPatches } };
  }
  const mine = code === 'no-cell-covered' && geometries.find((other) => other.flag === flag);
  const same = mine && geometries.find((other) => other !== mine && isSame(other, mine));
  if (!mine || !same) return null;
  const text = `${same.source.name} is on the page twice, and the later wins.`;
  const index = job?.geometries.findIndex(({ source }) => source === mine.surface) ?? -1;
  return { text, remedy: remedyOf('Remove it', { settings: {}, entries: [{ index, keys: null }] }) };
}

/** @param {import('hexcast').CertificateReport['overlaps'][number]} overlap @param {Report} report @returns {Finding} */
function ofOverlap({ winner, loser, cells, volume, place }, { unit }) {
  const text = `${winner} and ${loser} overlap in ${many(cells, 'cell')}, a volume of ${measure(volume, unit, 3)}: ${winner} has them.`;
  const subject = `the overlap of ${winner} and ${loser}`;
  return { kind: 'overlap', subject, title: TITLES.overlap, text, place, boxes: [], flag: null, remedies: [] };
}

/** @param {NonNullable<Leak['narrowest']>} narrowest @param {Leak} leak @param {Report} report @returns {Finding} */
function ofLeak({ width, centre }, { facets }, report) {
  const of = facets && facets.length > 0 ? ` ${many(facets.length, 'facet')} of ${namesOf(facets)} lie around it.` : '';
  const text = `The leak is narrowest at ${placeText(centre, report)}: a cube of ${many(width, 'cell')} passes, none of ${width + 1}.${of}`;
  const subject = 'the narrowest place of the leak';
  return { kind: 'leak', subject, title: TITLES.leak, text, place: centre, boxes: [], flag: null, remedies: [] };
}

/** @param {{ geometry: string }[]} facets */
function namesOf(facets) {
  return [...new Set(facets.map(({ geometry }) => geometry))].join(' and ');
}
