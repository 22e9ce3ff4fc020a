/**
 * The parameters (never the geometry) in the address, and the job as a command and as JavaScript.
 *
 * The hash holds the name of a file of lines, but not these. Else it holds what differs from the defaults, such as `#cells=256&padding=2&sample=knot&g=file%3Dknot.stl%26flag%3D7`.
 */
import { buttonOf, byId, debounce } from '../elements/dom.js';
import { GEOMETRY_KEYS, currentJob } from '../state/job.js';
import { flagsOf, numbersOf, writeNumbers } from '../text/format.js';
import { expectLooks, writeLooks } from './looks.js';
import { readMaterial, writeMaterial } from './material.js';
import { showNotice } from '../elements/messages.js';
import { expectLines, linesFile, waitedLines } from './lines.js';
import { DEFAULTS, MEASURED, colourOf, on, set, state } from '../state/state.js';

/** Settings of how cells are decided: keys of links, of jobs and, with hyphens, of the command. */
const METHOD = /** @type {const} */ (['rule', 'open', 'fill', 'close_gaps', 'certify', 'thin_cells', 'axis']);

/**
 * @typedef {import('hexcast').Job} Job
 * @typedef {import('../state/state.js').Settings} Settings
 * @typedef {import('../state/state.js').Geometry} Geometry
 * @typedef {Partial<Geometry> & { colour?: string }} GeometrySettings settings that a link has for a geometry
 */

/** @type {Record<'padding_by' | 'rule' | 'open' | 'fill' | 'stencil' | 'axis' | 'backend', string[]>} */
const CHOICES = {
  padding_by: ['cells', 'length'],
  rule: ['parity', 'nonzero'],
  open: ['winding', 'vote', 'error', 'parity'],
  fill: ['centre', 'conservative', 'separating'],
  stencil: ['D3Q7', 'D3Q15', 'D3Q19', 'D3Q27'],
  axis: ['auto', 'x', 'y', 'z'],
  backend: ['auto', 'gpu', 'cpu'],
};

/** Settings of a link for files that were not opened yet, in order. */
let expected = /** @type {{ query: string, file: string | null, settings: GeometrySettings }[]} */ ([]);
/** Hash that this page wrote last: it does not read its own. */
let written = /** @type {string | null} */ (null);

/** Writes the hash whenever a parameter changes. */
export function startSharing() {
  on(['settings', 'geometries', 'colours'], debounce(writeHash, 200));
  // a camera that moves does not put off the rest
  on(['look', 'legend'], debounce(writeHash, 200));
  on('geometries', () => {
    showCopies();
    if (state.geometries.length > 0) showWaiting();
  });
  // lines that were waited for
  on('settings', () => state.settings.sizing === 'lines' && showWaiting());
  showCopies();
  const copies = {
    'copy-command': () => commandOf(currentJob()),
    'copy-js': () => javascriptOf(currentJob()),
    'copy-link': () => {
      writeHash();
      return location.href;
    },
  };
  for (const [id, textOf] of Object.entries(copies)) {
    const button = buttonOf(id);
    button.addEventListener('click', () => copy(textOf(), button.textContent));
  }
}

/** Without a file there is nothing that a command or a program could mesh. */
function showCopies() {
  for (const id of ['copy-command', 'copy-js']) buttonOf(id).disabled = state.geometries.length === 0;
}

function writeHash() {
  const hash = ofArrival(hashOf());
  if (location.hash.slice(1) === hash) return;
  written = hash;
  history.replaceState(null, '', hash ? `#${hash}` : location.pathname + location.search);
}

/** The sample that the page took by itself is not in the address, unless something else is. @param {string} hash */
function ofArrival(hash) {
  const query = new URLSearchParams(hash);
  for (const key of ['sample', 'g']) query.delete(key);
  return state.isArrival && String(query) === '' ? '' : hash;
}

/** Whether the address was not changed by this page. */
export function isForeignHash() {
  return location.hash.slice(1) !== (written ?? '');
}

/** The parameters as they are in the address. */
export function hashOf() {
  const { settings, geometries } = state;
  const query = new URLSearchParams();
  const { sizing } = settings;
  const lines = linesFile();
  if (lines) query.set('lines', lines);
  if (sizing !== 'lines' && (sizing !== 'cells' || settings.cells !== DEFAULTS.cells))
    query.set(sizing, writeNumbers(settings[sizing === 'max_cell_size' ? 'cell_size' : sizing]));
  if (settings.domain) query.set('domain', settings.domain.join(' '));
  const ofLines = settings.sizing === 'graded' ? /** @type {const} */ (['min_size', 'growth', 'absorbing']) : [];
  const keys = /** @type {const} */ ([
    'padding',
    'padding_by',
    ...METHOD,
    ...MEASURED,
    'stencil',
    'fluid',
    'fraction_rays',
    'cut_fluid',
    'backend',
    'unit',
  ]);
  for (const key of [...ofLines, ...keys]) {
    if (String(settings[key]) !== String(DEFAULTS[key])) query.set(key, writeNumbers(settings[key]));
  }
  if (settings.background) query.set('background', writeMaterial(settings.background));
  const sample =
    geometries.length > 0 && geometries.every((geometry) => geometry.sample === geometries[0].sample) && geometries[0].sample;
  if (sample) query.set('sample', sample);
  for (const geometry of geometries) query.append('g', geometryQuery(geometry));
  writeLooks(query);
  // until files are opened, the settings of a link stay in the address
  if (geometries.length === 0) for (const entry of expected) query.append('g', entry.query);
  return query.toString();
}

/** @param {Geometry} geometry */
function geometryQuery(geometry) {
  const query = new URLSearchParams({ file: geometry.source.name });
  for (const [key, unsaid] of GEOMETRY_KEYS) {
    if (geometry[key] === unsaid || geometry[key] === null) continue;
    query.set(key, key === 'material' ? writeMaterial(geometry[key]) : writeNumbers(geometry[key]));
  }
  if (state.colours.has(geometry.flag)) query.set('colour', colourOf(geometry.flag).slice(1));
  return query.toString();
}

/** Takes the parameters of another address. @param {string} hash */
export function openHash(hash) {
  history.replaceState(null, '', hash ? `#${hash}` : location.pathname + location.search);
  readHash();
}

/** Says which files have settings in the link and are not here. */
function showWaiting(isSampleComing = false) {
  const names = [waitedLines(), ...(isSampleComing ? [] : expected.map(({ file }) => file))].filter(Boolean);
  const them = names.length === 1 ? 'that file' : 'these files';
  byId('waiting').textContent = names.length > 0 ? `This link has settings for ${names.join(', ')}: drop or choose ${them}.` : '';
  byId('waiting').hidden = names.length === 0;
}

/**
 * Reads the hash into the settings.
 *
 * @returns {string | null} the sample that it names
 */
export function readHash() {
  const query = new URLSearchParams(location.hash.slice(1));
  written = location.hash.slice(1);
  /** @type {Settings} */
  const patch = { ...DEFAULTS };
  for (const key of /** @type {const} */ (['cells', 'dims', 'cell_size', 'max_cell_size', 'graded'])) {
    const numbers = numbersOf(query.get(key) ?? '');
    const fits =
      key === 'dims'
        ? numbers?.length === 3
        : numbers?.length === 1 || (['cell_size', 'graded'].includes(key) && numbers?.length === 3);
    if (!fits || !numbers || numbers.some((number) => !(number > 0))) continue;
    patch.sizing = key;
    const value = numbers.length === 1 ? numbers[0] : numbers;
    Object.assign(patch, { [key === 'max_cell_size' ? 'cell_size' : key]: value });
  }
  const domain = numbersOf(query.get('domain') ?? '');
  if (domain?.length === 6) patch.domain = /** @type {Settings['domain']} */ (domain);
  const padding = numbersOf(query.get('padding') ?? '');
  if (padding?.length === 1) patch.padding = padding[0];
  if (padding?.length === 3) patch.padding = /** @type {import('../state/state.js').Triple} */ (padding);
  for (const [key, choices] of Object.entries(CHOICES)) {
    const value = query.get(key);
    if (value !== null && choices.includes(value)) Object.assign(patch, { [key]: value });
  }
  const gaps = Number(query.get('close_gaps') ?? NaN);
  if (Number.isInteger(gaps) && gaps > 1) patch.close_gaps = gaps;
  patch.certify = query.get('certify') === 'true';
  for (const key of MEASURED) patch[key] = query.get(key) === 'true';
  readLines(query, patch);
  const thin = Number(query.get('thin_cells') ?? NaN);
  if (Number.isInteger(thin) && thin > 0) patch.thin_cells = thin;
  const unit = query.get('unit') ?? DEFAULTS.unit;
  // such a unit is in every output
  patch.unit = /^[\p{L}\p{N}µ"']{0,16}$/u.test(unit) ? unit : DEFAULTS.unit;
  patch.background = readMaterial(query.get('background') ?? '') ?? null;
  patch.fluid = flagsOf(query.get('fluid') ?? '') ?? DEFAULTS.fluid;
  expectLines(query.get('lines'));
  expectLooks(query);
  expected = query.getAll('g').map(readGeometry);
  set(patch);
  showWaiting(query.has('sample'));
  return query.get('sample');
}

/** Reads how lines are generated, how finely fractions are measured, and which flag is cut. @param {URLSearchParams} query @param {Settings} patch */
function readLines(query, patch) {
  const number = (/** @type {string} */ key) => Number(query.get(key) ?? NaN);
  if (number('min_size') > 0) patch.min_size = number('min_size');
  if (number('growth') >= 1.01 && number('growth') <= 10) patch.growth = number('growth');
  if ([0, 1, 2, 4, 8, 16].includes(number('fraction_rays'))) patch.fraction_rays = number('fraction_rays');
  const cut = number('cut_fluid');
  if (query.has('cut_fluid') && Number.isInteger(cut) && cut >= 0 && cut <= 255) patch.cut_fluid = cut;
  const absorbing = numbersOf(query.get('absorbing') ?? '');
  const isRight = absorbing?.every((cells) => Number.isInteger(cells) && cells >= 0 && cells <= 1024);
  if (isRight && absorbing?.length === 1) patch.absorbing = absorbing[0];
  if (isRight && absorbing?.length === 3) patch.absorbing = /** @type {import('../state/state.js').Triple} */ (absorbing);
}

/** @param {string} text */
function readGeometry(text) {
  const query = new URLSearchParams(text);
  /** @type {GeometrySettings} */
  const settings = {};
  const flag = Number(query.get('flag'));
  if (Number.isInteger(flag) && flag >= 1 && flag <= 255) settings.flag = flag;
  const priority = Number(query.get('priority') ?? NaN);
  if (Number.isInteger(priority)) settings.priority = priority;
  const fill = /** @type {Settings['fill'][]} */ (CHOICES.fill).find((known) => known === query.get('fill'));
  if (fill) settings.fill = fill;
  if (query.get('split') === 'true') settings.split = true;
  const name = query.get('name');
  if (name) settings.name = name;
  if (query.get('metal') === 'true') settings.metal = true;
  const material = readMaterial(query.get('material') ?? '');
  if (material) settings.material = material;
  const [most, fewest] = ['max_size', 'min_cells'].map((key) => Number(query.get(key) ?? NaN));
  if (most > 0 && most < Infinity) settings.max_size = most;
  if (Number.isInteger(fewest) && fewest > 0) settings.min_cells = fewest;
  for (const key of ['scale', 'rotate', 'about', 'translate']) {
    const numbers = numbersOf(query.get(key) ?? '');
    if (numbers?.length === 3) Object.assign(settings, { [key]: numbers });
    else if (numbers?.length === 1 && key === 'scale') settings.scale = numbers[0];
  }
  if (/^[0-9a-f]{6}$/.test(query.get('colour') ?? '')) settings.colour = `#${query.get('colour')}`;
  return { query: text, file: query.get('file'), settings };
}

/** Takes the settings that the link has for a file of this name, once. @param {string} file @returns {GeometrySettings} */
export function takeExpected(file) {
  const at = expected.findIndex((entry) => entry.file === file);
  return at < 0 ? {} : expected.splice(at, 1)[0].settings;
}

/** Keys and values as an argument has them. @param {object} settings */
function pairs(settings) {
  return Object.entries(settings).map(([key, value]) => `${key}=${Array.isArray(value) ? value.join('/') : value}`);
}

/** The native command that does this job. @param {ReturnType<typeof currentJob>} job */
export function commandOf(job) {
  const words = ['hexcast', 'mesh'];
  for (const { source: _, file: name, material, ...settings } of job.geometries) {
    // else it would be an option
    const file = name.startsWith('-') ? `./${name}` : name;
    const given = pairs({ ...settings, ...material });
    words.push(quote(given.length > 0 ? `${file}:${given.join(',')}` : file));
  }
  const option = (/** @type {string} */ name, /** @type {unknown} */ value) => {
    if (value === true) words.push(`--${name}`);
    else if (value !== undefined) words.push(`--${name}=${quote([value].flat().join(','))}`);
  };
  option('domain', job.domain);
  if (job.padding && 'cells' in job.padding) option('padding-cells', job.padding.cells);
  if (job.padding && 'length' in job.padding) option('padding-length', job.padding.length);
  for (const key of /** @type {const} */ (['cells', 'dims', 'cell_size', 'max_cell_size', ...METHOD, 'unit']))
    option(key.replaceAll('_', '-'), job[key]);
  option('background', job.background && pairs(job.background.material ?? {}).join(','));
  option('lines', job.lines && state.settings.lines?.file);
  option('graded', job.graded?.max_size);
  option('min-size', job.graded?.min_size);
  option('growth', job.graded?.growth);
  option('absorbing', job.graded?.absorbing);
  const file = (/** @type {string} */ of) => (job[/** @type {'links'} */ (of)] ? `${baseName(job)}-${of}.npz` : undefined);
  for (const of of ['links', 'fractions', 'staggered', 'conformal', 'tensors', 'distance']) option(of, file(of));
  option('stencil', job.links?.stencil);
  option('fluid', job.links?.fluid);
  option('fraction-method', job.fractions?.method);
  option('fraction-rays', job.fractions?.rays);
  option('fraction-faces', job.fractions?.faces || undefined);
  option('fraction-surfaces', job.fractions?.surfaces || undefined);
  option('fraction-edges', job.fractions?.edges);
  option('fraction-centroids', job.fractions?.centroids);
  if (state.settings.backend !== 'auto') option('backend', state.settings.backend);
  option('cut', job.cut_cells ? true : undefined);
  option('export-flags', job.cut_cells?.fluid);
  const endings = [job.graded || job.lines ? 'vtr' : 'vti', ...(job.cut_cells ? ['foam'] : [])];
  return [...words, ...endings.flatMap((ending) => ['-o', quote(`${baseName(job)}.${ending}`)])].join(' ');
}

/** A program that does this job with the package. @param {ReturnType<typeof currentJob>} job */
export function javascriptOf({ geometries, ...rest }) {
  const names = geometries.map(({ file }) => JSON.stringify(file)).join(', ');
  const options = state.settings.backend === 'auto' ? '' : `{ backend: '${state.settings.backend}' }`;
  return [
    "import { createMesher } from 'hexcast';",
    '',
    `/** files: ${names}, as Blobs or bytes, in this order */`,
    'export async function mesh(files) {',
    `  const mesher = await createMesher(${options});`,
    '  return mesher.mesh({',
    '    geometries: [',
    ...geometries.map(({ source: _, ...geometry }, at) => `      { source: files[${at}], ${inside(geometry)} },`),
    '    ],',
    ...Object.entries(rest).map(([key, value]) => `    ${key}: ${JSON.stringify(value)},`),
    '  });',
    '}',
    '',
  ].join('\n');
}

/** The keys of an object literal, without its braces. @param {object} value */
function inside(value) {
  return Object.entries(value)
    .map(([key, part]) => `${key}: ${JSON.stringify(part)}`)
    .join(', ');
}

/** Name for files of a job: that of its first geometry. @param {import('../state/state.js').ShownJob | null} job */
export function baseName(job) {
  const name = job?.geometries[0]?.name ?? job?.geometries[0]?.file?.replace(/\.[^.]*$/, '') ?? 'mesh';
  return name.replace(/[^\p{L}\p{N}._-]+/gu, '-') || 'mesh';
}

/** A word for a POSIX shell. @param {string} word */
function quote(word) {
  return /^[\w./:=,+-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`;
}

/** @param {string} text @param {string} what */
async function copy(text, what) {
  const field = /** @type {HTMLTextAreaElement} */ (byId('copied-text'));
  field.value = text;
  byId('copied').hidden = false;
  try {
    await navigator.clipboard.writeText(text);
    byId('share-status').textContent = `${what} copied.`;
  } catch {
    field.select();
    byId('share-status').textContent = 'The browser does not let pages copy here; the text is selected below.';
    if (!document.execCommand?.('copy')) showNotice('press Ctrl+C to copy the selected text');
  }
}
