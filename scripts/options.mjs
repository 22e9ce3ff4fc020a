// npm run options: writes, from docs/job.schema.json, all that lists the options of a job outside of Rust: the types of the package, the
// names and types of the wheel, and the reference page; and from docs/formats.json the rows of formats of the package. Both are made of the
// Rust types and writers; `npm test` compares what is here with them.

import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

import { ROOT } from './run.mjs';

/**
 * @typedef {{$ref?: string, type?: string | string[], description?: string, default?: any, const?: string, anyOf?: Schema[], oneOf?: Schema[],
 *   items?: Schema, minItems?: number, properties?: Record<string, Schema>, required?: string[]}} Schema
 */

const COMMAND = '`npm run options` of docs/job.schema.json';
/** Definitions that are types by their own names, in the order in which they are written. */
const NAMED = [
  'Material',
  'GeometryJob',
  'GradedJob',
  'LinksJob',
  'FractionsJob',
  'ConformalJob',
  'AnisotropicJob',
  'TensorsJob',
  'DistanceJob',
  'CutCellsJob',
];
/** Keys that only the native program has. */
const NATIVE = ['backend', 'deviation'];
/** Definitions with keys of their own, in the order of the reference. */
const INNER = [
  'Material',
  'Padding',
  'LinesJob',
  'GradedJob',
  'PartJob',
  'ZarrJob',
  'LinksJob',
  'FractionsJob',
  'ConformalJob',
  'DistanceJob',
  'TensorsJob',
  'AnisotropicJob',
  'CutCellsJob',
  'BackgroundJob',
  'SliceJob',
  'ViewJob',
];
/** What holds in JavaScript alone. @type {Record<string, string>} */
const IN_JAVASCRIPT = {
  max_cells: 'A mesh of more fails with `too-many-cells`.',
  max_memory:
    'By default 3 GiB. A mesh that needs more fails with `memory`, unless its columns can spill: see `MeshOptions.spill`.',
  links: 'See `Mesh.links`.',
  fractions: 'See `Mesh.fractions`.',
  staggered: 'See `Mesh.staggered`.',
  conformal: 'See `Mesh.conformal`.',
  distance: 'See `Mesh.distance`.',
  tensors: 'See `Mesh.tensors`.',
  cut_cells: 'Files of `foam` then have cut cells; `eb` needs `boundary`.',
};
/** What holds in Python alone. @type {Record<string, string>} */
const IN_PYTHON = {
  padding: 'Such as `{"cells": 4}` or `{"length": 0.5}`.',
  lines: 'Such as `{"x": [...], "y": [...], "z": [...]}`.',
  max_cells: 'By default 10^12.',
  part: 'Also `"3/64"` of slabs across z, `"3/4x4x4"` of boxes.',
  certify: 'What is found is in `report["certificate"]`.',
  links: 'Counted in `report["links"]`.',
  fractions: 'Counted in `report["fractions"]`.',
  staggered: 'Counted in `report["staggered"]`.',
  conformal: 'Counted in `report["conformal"]`.',
  distance: 'Described in `report["distance"]`.',
  tensors: 'Counted in `report["tensors"]`.',
  cut_cells: 'Files that end in `.foam` then have cut cells; `.eb` needs `boundary`.',
  max_memory: 'By default 3/4 of what is available.',
  background: 'Such as `{"name": "air", "material": {"eps_r": 1}}`.',
};
/** What Python takes besides what the schema says. @type {Record<string, string>} */
const PYTHON_TYPES = { part: 'Union[str, Mapping[str, Any]]' };

/** @param {string} file @returns {any} */
const readJson = (file) => JSON.parse(readFileSync(path.join(ROOT, file), 'utf8'));

const schema = readJson('docs/job.schema.json');
/** @type {Record<string, Schema>} */
const definitions = schema.$defs;
/** @type {string[]} */
const jobKeys = Object.keys(readJson('docs/report.schema.json').$defs.Job.properties);
/** Keys of a job, and those that only a job file has: what the command does with its mesh. @type {[string, Schema][]} */
const ofJob = jobKeys.map((key) => [key, schema.properties[key]]);
/** @type {[string, Schema][]} */
const ofFile = Object.entries(/** @type {Record<string, Schema>} */ (schema.properties)).filter(
  ([key]) => !jobKeys.includes(key),
);

/** The definition that a value refers to, or the value itself; null, which every optional key may be, is left out. @param {Schema} value */
function resolved(value) {
  const some = value.anyOf?.filter((of) => of.type !== 'null');
  const only = some?.length === 1 ? some[0] : value;
  const name = only.$ref?.replace('#/$defs/', '');
  return { name, value: name === undefined ? only : definitions[name] };
}

/** Kind of a plain value. @param {Schema} value */
const kindOf = (value) => (Array.isArray(value.type) ? value.type.find((type) => type !== 'null') : value.type);

/** The words of an enumeration; null where it is none. @param {Schema} value @returns {Schema[] | null} */
const wordsOf = (value) => (value.oneOf?.every((of) => of.const !== undefined) ? value.oneOf : null);

/** A type of TypeScript. @param {Schema} given @returns {string} */
function typescript(given) {
  const { name, value } = resolved(given);
  if (name !== undefined && NAMED.includes(name)) return name;
  const words = wordsOf(value);
  if (words) return words.map((word) => `'${word.const}'`).join(' | ');
  const choices = value.anyOf ?? value.oneOf;
  if (choices) return [...new Set(choices.filter((of) => of.type !== 'null').map(typescript))].join(' | ');
  switch (kindOf(value)) {
    case 'array':
      return typescriptArray(value);
    case 'object':
      return `{ ${Object.entries(value.properties ?? {})
        .map(([key, of]) => `readonly ${key}${value.required?.includes(key) ? '' : '?'}: ${typescript(of)}`)
        .join('; ')} }`;
    case 'integer':
    case 'number':
      return 'number';
    default:
      return kindOf(value) ?? 'unknown';
  }
}

/** @param {Schema} value */
function typescriptArray(value) {
  const item = /** @type {Schema} */ (value.items);
  const n = value.minItems;
  if (n === 3) return 'Triple';
  if (n !== undefined) return `readonly [${Array(n).fill('number').join(', ')}]`;
  if (item.type === 'number') return 'Numbers';
  const of = typescript(item);
  return `readonly ${of.includes('|') ? `(${of})` : of}[]`;
}

/** A type of Python. @param {Schema} given @returns {string} */
function python(given) {
  const { value } = resolved(given);
  const words = wordsOf(value);
  if (words) return `Literal[${words.map((word) => `"${word.const}"`).join(', ')}]`;
  const choices = value.anyOf ?? value.oneOf;
  if (choices) {
    const types = [...new Set(choices.filter((of) => of.type !== 'null').map(python))];
    if (types.some((type) => type.startsWith('Sequence['))) return 'PerAxis';
    return types.length === 1 ? types[0] : `Union[${types.join(', ')}]`;
  }
  switch (kindOf(value)) {
    case 'array':
      return `Sequence[${python(/** @type {Schema} */ (value.items))}]`;
    case 'object': {
      const types = new Set(Object.values(value.properties ?? {}).map(python));
      return `Mapping[str, ${types.size === 1 ? [...types][0] : 'Any'}]`;
    }
    case 'integer':
      return 'int';
    case 'number':
      return 'float';
    case 'boolean':
      return 'bool';
    default:
      return 'str';
  }
}

/** What a key means: its own sentences, what its words mean, its keys, and its default. @param {Schema} given @param {boolean} keys */
function meaning(given, keys) {
  const { value } = resolved(given);
  const words = wordsOf(value)?.map((word) => `\`${word.const}\`: ${lowered(word.description ?? '')}`) ?? [];
  const inner =
    keys && value.properties
      ? [
          `Keys: ${Object.keys(value.properties)
            .map((key) => `\`${key}\``)
            .join(', ')}.`,
        ]
      : [];
  const standard = given.default;
  const isSaid =
    standard === undefined ||
    standard === '' ||
    standard === false ||
    typeof standard === 'object' ||
    /by default/.test(given.description ?? '');
  return [given.description ?? '', ...words, ...inner, ...(isSaid ? [] : [`Default \`${standard}\`.`])].join(' ');
}

/** @param {string} text */
const lowered = (text) =>
  text.replace(/^(None|Not|Inside|The|Every|By|At|Most|Over|Along|Background|Cells|Only|Whole)\b/, (word) => word.toLowerCase());

/** Words in lines of at most `width` characters. @param {string} text @param {number} width @returns {string[]} */
function wrapped(text, width) {
  /** @type {string[]} */
  const lines = [];
  for (const word of text.split(' ')) {
    const last = lines.at(-1);
    if (last !== undefined && last.length + 1 + word.length <= width) lines[lines.length - 1] = `${last} ${word}`;
    else lines.push(word);
  }
  return lines;
}

/** A comment of TypeScript. @param {string} text @param {string} indent */
function comment(text, indent) {
  if (indent.length + text.length + 7 <= 150) return `${indent}/** ${text} */\n`;
  return `${indent}/**\n${wrapped(text, 140 - indent.length)
    .map((line) => `${indent} * ${line}\n`)
    .join('')}${indent} */\n`;
}

/** The keys of a definition, and whether each is needed. @param {Schema} definition @returns {[string, Schema, boolean][]} */
const keysOf = ({ properties = {}, required = [] }) =>
  Object.entries(properties).map(([key, of]) => [key, of, required.includes(key)]);

/** An interface. @param {string} name @param {string} text @param {[string, Schema, boolean][]} keys @param {string} first lines @param {Record<string, string>} sentences more of them by key */
function interfaceOf(name, text, keys, first = '', sentences = {}) {
  const fields = keys.map(([key, of, isNeeded]) => {
    const text = [meaning(of, false), sentences[key] ?? []].flat().join(' ');
    return `${comment(text, '  ')}${field(`  ${key}${isNeeded ? '' : '?'}: `, typescript(of))}`;
  });
  return `\n${comment(text, '')}export interface ${name} {\n${first}${fields.join('')}}\n`;
}

/** A field, in lines of the length that Biome wants. @param {string} before its name @param {string} type */
function field(before, type) {
  if (before.length + type.length < 130 || !type.startsWith('{ ')) return `${before}${type};\n`;
  const inner = type.slice(2, -2).split('; ');
  return `${before}{\n${inner.map((of) => `    ${of};\n`).join('')}  };\n`;
}

/** `www/types/options.d.ts`. */
function types() {
  const named = NAMED.map((name) => {
    const keys = keysOf(definitions[name]);
    if (name !== 'GeometryJob') return interfaceOf(name, definitions[name].description ?? '', keys);
    const file = '  /** Name of the file in reports; by default that of the File, or `geometry-1`, ... */\n  file?: string;\n';
    const source = '  /** The facets. */\n  source: GeometrySource;\n';
    return interfaceOf(
      name,
      'A surface, the name and flag of its cells, and its transform.',
      keys.filter(([key]) => key !== 'file'),
      source + file,
    );
  });
  const keys = keysOf(schema).filter(([key]) => jobKeys.includes(key) && !NATIVE.includes(key));
  const text = 'What is meshed and how: the native job file, with sources in place of file names.';
  return [
    `/** The job: what is meshed, and how. Made by ${COMMAND}. */\n`,
    "import type { GeometrySource, Numbers } from './job.js';\nimport type { Triple } from './result.js';\n",
    ...named,
    interfaceOf('Job', text, keys, '', IN_JAVASCRIPT),
  ].join('');
}

/** Names and types of keys in Python. @param {[string, Schema][]} keys @param {Record<string, string>} more sentences by key */
function annotations(keys, more = {}) {
  const lines = keys.map(([key, of]) => {
    const text = [meaning(of, true), more[key] ?? []].flat().join(' ').replaceAll('`', '``');
    return `${wrapped(text, 132)
      .map((line) => `    #: ${line}\n`)
      .join('')}    ${key}: ${PYTHON_TYPES[key] ?? python(of)}\n`;
  });
  return lines.join('');
}

/** `python/package/hexcast/_options.py`. */
function names() {
  const geometry = Object.entries(definitions.GeometryJob.properties ?? {}).filter(([key]) => key !== 'file');
  return `"""The options of a mesh and of a geometry: those of a job file, with the same meaning. Made by ${COMMAND.replaceAll('`', '``')}."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Union

if TYPE_CHECKING:
    from ._surface import SurfaceLike

PerAxis = Union[float, Sequence[float]]


class GeometryOptions(TypedDict, total=False):
    """A surface and what its cells shall be: \`\`file\`\` or \`\`source\`\`, and the keys of \`\`[[geometries]]\`\` in a job file."""

    #: Name of a file: STL, OBJ, PLY, OFF, 3MF or GLB, also packed by gzip.
    file: str
    #: A surface in memory, in place of \`\`file\`\`: see :func:\`hexcast.surface\`.
    source: SurfaceLike
${annotations(geometry)}

class JobOptions(TypedDict, total=False):
    """The options of a mesh: the keys of a job file. Lengths are in the unit of the surfaces."""

${annotations(
  ofJob.filter(([key]) => key !== 'geometries'),
  IN_PYTHON,
)}

#: Names of the options of a geometry, and of a job.
GEOMETRY_KEYS = tuple(GeometryOptions.__annotations__)
JOB_KEYS = tuple(JobOptions.__annotations__)
`;
}

/** What a value is, in words. @param {Schema} given @returns {string} */
function words(given) {
  const { name, value } = resolved(given);
  if (name === 'ByteSize' || name === 'Level') return 'number or text';
  if (name === 'Names') return 'text, or list of texts';
  const some = wordsOf(value);
  if (some) return some.map((word) => `\`${word.const}\``).join(', ');
  if (name?.startsWith('PerAxis')) return 'number, or 3 numbers';
  const choices = value.anyOf ?? value.oneOf;
  if (choices?.every((of) => kindOf(resolved(of).value) === 'object')) return 'table';
  if (choices) return 'table, or list of them';
  switch (kindOf(value)) {
    case 'array': {
      const item = resolved(/** @type {Schema} */ (value.items)).value;
      const of = wordsOf(item) ? words(item) : ({ string: 'texts', object: 'tables' }[kindOf(item) ?? ''] ?? 'numbers');
      return value.minItems === undefined ? `list of ${of}` : `${value.minItems} ${of}`;
    }
    case 'object':
      return 'table';
    case 'integer':
      return 'whole number';
    case 'boolean':
      return 'true or false';
    case 'string':
      return 'text';
    default:
      return 'number';
  }
}

/** A table of keys. @param {[string, Schema][]} keys */
function table(keys) {
  const rows = keys.map(([key, of]) => `| \`${key}\` | ${words(of)} | ${meaning(of, false).replaceAll('|', '\\|')} |\n`);
  return `| key | value | meaning |\n|---|---|---|\n${rows.join('')}`;
}

/** `docs/options.md`. */
function reference() {
  const keysOfGeometry = Object.entries(definitions.GeometryJob.properties ?? {});
  const users = [...ofJob, ...ofFile, ...keysOfGeometry];
  const inner = INNER.map((name) => {
    const { description = '', properties = {}, oneOf = [] } = definitions[name];
    // of some only one key is given
    const chosen = oneOf.flatMap((of) =>
      Object.entries(of.properties ?? {}).map(([key, value]) => [key, { ...value, description: of.description }]),
    );
    const isOf = new RegExp(`/([A-Z][a-z]+_)?${name}"`);
    const keys = [...new Set(users.filter(([, of]) => isOf.test(JSON.stringify(of))).map(([key]) => `\`${key}\``))];
    const rows = /** @type {[string, Schema][]} */ ([...Object.entries(properties), ...chosen]);
    return `\n## Keys of ${keys.join(' and ')}\n\n${description}\n\n${table(rows)}`;
  });
  return `# Options

All keys of a job file, made of the types of the program (\`npm run options\`, [job.schema.json](job.schema.json)). They are the same everywhere: in a job
file (TOML or JSON, \`hexcast mesh --job JOB.toml\`), in Python as arguments of \`hexcast.mesh\`, in JavaScript as properties of a \`Job\`. On the command line an
option is \`--\` and its key, of most, with \`-\` for \`_\`; \`hexcast mesh --help\` lists all. Lengths are in the unit of the files. No key but \`geometries\` is needed.

## The job

${table(ofJob)}
## A geometry

Keys of each of the \`geometries\`; on the command line \`FILE:key=value,key=value\`.

${table(keysOfGeometry)}
## What the command does

Keys of a job file alone. In JavaScript and Python these are arguments of what writes a mesh.

${table(ofFile)}${inner.join('')}`;
}

/** The facts of formats, which the writers are asked for. @type {Record<string, import('../www/types/result.js').FormatFacts>} */
const formats = readJson('docs/formats.json');
const OF_FORMATS = '`npm run options` of docs/formats.json';

/** `www/client/format_rows.js`. */
function rows() {
  const word = (/** @type {unknown} */ value) => (typeof value === 'string' ? `'${value}'` : `${value}`);
  const rows = Object.entries(formats).map(([name, facts]) => {
    const { kind, type, compresses, ascii, unit, spacing, ...of } = facts;
    const values = [kind, type, compresses, ascii, unit, spacing].map(word);
    const more = Object.entries(of).map(([key, value]) => `${key}: ${word(value)}`);
    if (more.length > 0) values.push(`{ ${more.join(', ')} }`);
    const key = /^\w+$/.test(name) ? name : `'${name}'`;
    const line = `  ${key}: row(${values.join(', ')}),\n`;
    if (line.length <= 131) return line;
    const last = values
      .pop()
      ?.replace('{ ', '{\n    ')
      .replaceAll(/', (?=\w+: )/g, "',\n    ")
      .replace(' }', ',\n  }');
    return `  ${key}: row(${values.join(', ')}, ${last}),\n`;
  });
  return `/** What each format is and can hold. Made by ${OF_FORMATS}. */

/** @typedef {import('../hexcast.js').FormatFacts} Facts */

/**
 * @param {Facts['kind']} kind @param {string} type @param {boolean} compresses @param {boolean} ascii @param {boolean} unit
 * @param {Facts['spacing']} spacing @param {Pick<Facts, 'program' | 'about' | 'file'>} [of] another program @returns {Facts}
 */
const row = (kind, type, compresses, ascii, unit, spacing, of) =>
  Object.freeze({ kind, type, compresses, ascii, unit, spacing, ...of });

/** @type {typeof import('../hexcast.js').formats} */
export const FORMATS = Object.freeze({
${rows.join('')}});
`;
}

/** `www/types/formats.d.ts`. */
function formatNames() {
  const of = (/** @type {string} */ kind) => {
    const names = Object.keys(formats).filter((name) => formats[name].kind === kind);
    const line = names.map((name) => `'${name}'`).join(' | ');
    return line.length < 100 ? ` ${line}` : `\n  | ${line.replaceAll(' | ', '\n  | ')}`;
  };
  return `/** Names of formats. Made by ${OF_FORMATS}. */

/** Files of the flags. */
export type CellsFormat =${of('cells')};
/** Files of what a job asked for besides. */
export type MeasuredFormat =${of('measured')};
/** Files of other programs. */
export type ProgramFormat =${of('export')};
`;
}

/** The files, and what shall be in them. @returns {Record<string, string>} */
export function generated() {
  return {
    'www/types/options.d.ts': types(),
    'python/package/hexcast/_options.py': names(),
    'docs/options.md': reference(),
    'www/client/format_rows.js': rows(),
    'www/types/formats.d.ts': formatNames(),
  };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  for (const [file, text] of Object.entries(generated())) {
    writeFileSync(path.join(ROOT, file), text);
    console.log(file);
  }
}
