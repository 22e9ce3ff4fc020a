// The fields of the page offer what the schema of a job knows: the same choices, and no number below its range.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';

import { ROOT } from '../../scripts/run.mjs';

const page = readFileSync(path.join(ROOT, 'www/index.html'), 'utf8');
const schema = JSON.parse(readFileSync(path.join(ROOT, 'docs/job.schema.json'), 'utf8'));

/** Fields by their id, and the place of what they set in a job. */
const FIELDS = {
  rule: ['rule'],
  open: ['open'],
  fill: ['fill'],
  axis: ['axis'],
  backend: ['backend'],
  stencil: ['links', 'stencil'],
  'fraction-rays': ['fractions', 'rays'],
  cells: ['cells'],
  'close-gaps': ['close_gaps'],
  'thin-cells': ['thin_cells'],
  'graded-growth': ['graded', 'growth'],
};

/** A part of the schema with what it refers to. */
function resolved(part) {
  const of = part.anyOf?.find(({ type }) => type !== 'null') ?? part;
  return of.$ref ? schema.$defs[of.$ref.split('/').at(-1)] : of;
}

/** The part of the schema at a place in a job. */
function at(keys) {
  return keys.reduce((part, key) => {
    const of = part.properties?.[key];
    assert.ok(of, `a job has ${keys.join('.')}`);
    return resolved(of);
  }, schema);
}

for (const [id, keys] of Object.entries(FIELDS)) {
  test(`the field ${id} of the page is that of the schema`, () => {
    const tag = new RegExp(`<(select|input)[^>]* id="${id}"[^>]*>([\\s\\S]*?</select>)?`).exec(page);
    assert.ok(tag, `the page has the field ${id}`);
    const part = at(keys);
    const min = Number(/ min="([^"]*)"/.exec(tag[0])?.[1] ?? 0);
    assert.ok(min >= (part.minimum ?? 0), `${id} begins at ${min}`);
    if (!part.oneOf) return;
    const offered = [...tag[2].matchAll(/<option(?: value="([^"]*)")?>([^<]*)/g)].map(([, value, text]) => value ?? text);
    assert.deepEqual(offered.toSorted(), part.oneOf.map((choice) => choice.const).toSorted());
  });
}

test('every choice of the form is held to the schema', () => {
  const form = page.slice(page.indexOf('<form id="settings"'), page.indexOf('</form>'));
  const ids = [...form.matchAll(/<select id="([^"]*)"/g)].map(([, id]) => id);
  // units may be any, and how padding is measured is the page's
  assert.deepEqual(ids.filter((id) => !(id in FIELDS)).toSorted(), ['padding-by', 'unit']);
});
