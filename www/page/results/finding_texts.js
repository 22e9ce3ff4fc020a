/** What a mesh found: the findings of its report, overlaps of its certificate, and a leak; each in words, with a place and what helps. */
import { measure } from '../text/format.js';
import { sentence } from '../elements/messages.js';
import { many, placeText } from '../text/places.js';
import { removeGeometry } from '../geometries/files.js';
import { joinPatches } from '../geometries/patches.js';
import { remediesOf } from './remedies.js';
import { isSame, state } from '../state/state.js';

/** @typedef {import('hexcast').Report} Report @typedef {import('hexcast').Leak} Leak @typedef {import('../state/state.js').Finding} Finding */

/**
 * All findings of a report, and that of a leak. A column file holds none of the report; what meshed is said at the head of the page.
 *
 * @param {Report} report
 * @param {Leak | null} leak
 * @returns {Finding[]}
 */
export function findingsOf(report, leak) {
  return [
    ...report.findings.map(ofReport),
    ...(report.certificate?.overlaps ?? []).map((overlap) => ofOverlap(overlap, report)),
    ...(leak?.narrowest ? [ofLeak(leak.narrowest, leak, report)] : []),
  ];
}

/** @param {import('hexcast').Finding} finding @returns {Finding} */
function ofReport(finding) {
  const { code, geometry, axis, points, boxes } = finding;
  const subject = `${geometry?.name ?? 'the mesh'}${axis ? ` along ${axis}` : ''}`;
  const [box] = boxes;
  const place = points[0] ?? (box ? box[0].map((low, axis) => (low + box[1][axis]) / 2) : null);
  const known = fromPage(finding);
  const text = [sentence(finding.sentence), ...(known ? [known.text] : [])].join(' ');
  return { kind: code, subject, text, place, remedies: known ? [known.remedy] : remediesOf(finding) };
}

/** What only the page knows of a finding, as it has the files. @param {import('hexcast').Finding} finding */
function fromPage({ code, geometry, flag }) {
  const { geometries, patches } = state;
  if (code === 'surface-open' && patches?.some(({ name }) => name === geometry?.name)) {
    const others = patches.filter(({ name }) => name !== geometry?.name).map(({ name }) => name);
    const text = `With ${others.join(' and ')} it is one closed surface, of which it is a part.`;
    return { text, remedy: { label: 'Join the parts', act: joinPatches } };
  }
  const mine = code === 'no-cell-covered' && geometries.find((other) => other.flag === flag);
  const same = mine && geometries.find((other) => other !== mine && isSame(other, mine));
  if (!mine || !same) return null;
  const text = `${same.source.name} is on the page twice, and the later wins.`;
  return { text, remedy: { label: 'Remove it', act: () => removeGeometry(mine.id) } };
}

/** @param {import('hexcast').CertificateReport['overlaps'][number]} overlap @param {Report} report @returns {Finding} */
function ofOverlap({ winner, loser, cells, volume, place }, { unit }) {
  const text = `${winner} and ${loser} overlap in ${many(cells, 'cell')}, a volume of ${measure(volume, unit, 3)}: ${winner} has them.`;
  return { kind: 'overlap', subject: `the overlap of ${winner} and ${loser}`, text, place, remedies: [] };
}

/** @param {NonNullable<Leak['narrowest']>} narrowest @param {Leak} leak @param {Report} report @returns {Finding} */
function ofLeak({ width, centre }, { facets }, report) {
  const of = facets && facets.length > 0 ? ` ${many(facets.length, 'facet')} of ${namesOf(facets)} lie around it.` : '';
  const text = `The leak is narrowest at ${placeText(centre, report)}: a cube of ${many(width, 'cell')} passes, none of ${width + 1}.${of}`;
  return { kind: 'leak', subject: 'the narrowest place of the leak', text, place: centre, remedies: [] };
}

/** @param {{ geometry: string }[]} facets */
function namesOf(facets) {
  return [...new Set(facets.map(({ geometry }) => geometry))].join(' and ');
}
