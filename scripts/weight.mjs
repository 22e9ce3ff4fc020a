// npm run weight: how heavy the house is. It counts what is compiled, written and kept in one folder; "npm run weight -- --builds" also
// measures the first build and two rebuilds, with an empty target folder of its own and the registry that cargo has.

import { execFileSync } from 'node:child_process';
import { appendFileSync, existsSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

import { ROOT, run } from './run.mjs';

/** Folders of source, as they are read: none holds what a build made. */
const SOURCE = ['src', 'crates', 'capi/src', 'python/src', 'shaders', 'www', 'python/package', 'scripts'];
/** An option and a format as examples of what names one: where they occur is where a new one would have to be written. */
const OPTION = /\bclose_gaps\b|\bcloseGaps\b|--close-gaps/;
const FORMAT = /\bbinvox\b/i;

/** All files below a folder of the repository. @param {string} folder @returns {string[]} */
function filesIn(folder) {
  return readdirSync(path.join(ROOT, folder), { withFileTypes: true }).flatMap((entry) => {
    const name = `${folder}/${entry.name}`;
    if (entry.name === '__pycache__') return [];
    return entry.isDirectory() ? filesIn(name) : [name];
  });
}

/** @param {string} file */
const read = (file) => readFileSync(path.join(ROOT, file), 'utf8');

/** Whether a file holds tests alone. @param {string} file */
export function isTest(file) {
  return /(^|\/)(tests(\/|\.rs$)|testing\.rs$)/.test(file);
}

/**
 * Lines that are code: neither empty nor a comment nor in a module of tests.
 *
 * @param {string} text @param {string} ending of the file: rs, js, py or another
 * @returns {number}
 */
export function codeLines(text, ending) {
  const comment = ending === 'py' ? /^#/ : /^\/\//;
  let code = ending === 'rs' ? text.replace(/^( *)#\[cfg\(test\)\]\n\1(pub )?mod \w+ \{\n[\s\S]*?^\1\}\n/gm, '') : text;
  code = ending === 'py' ? code.replace(/"""[\s\S]*?"""/g, '') : code.replace(/^\s*\/\*[\s\S]*?\*\//gm, '');
  return code.split('\n').filter((line) => line.trim() !== '' && !comment.test(line.trim())).length;
}

/** Code lines of the files of these endings below folders, without tests. @param {string[]} files */
function codeOf(files) {
  return files.filter((file) => !isTest(file)).reduce((sum, file) => sum + codeLines(read(file), path.extname(file).slice(1)), 0);
}

/** Folders by their number of entries, the largest first. @param {string[]} folders @returns {[string, number][]} */
export function byEntries(folders) {
  const all = folders.flatMap((folder) => [folder, ...filesIn(folder).map((file) => path.posix.dirname(file))]);
  const counts = [...new Set(all)].map((folder) => [folder, readdirSync(path.join(ROOT, folder)).length]);
  return /** @type {[string, number][]} */ (counts).sort((a, b) => Number(b[1]) - Number(a[1]));
}

/** Crates that a build of the command compiles, other than hexcast. */
function dependencies() {
  const args = ['tree', '--package', 'hexcast', '--edges', 'normal,build', '--prefix', 'none', '--format', '{p}'];
  const lines = execFileSync('cargo', args, { cwd: ROOT, encoding: 'utf8' }).split('\n');
  const names = new Set(lines.map((line) => line.replace(/ \(.*$/, '')).filter((line) => line !== ''));
  return [...names].filter((name) => !name.startsWith('hexcast')).length;
}

/** Files outside of tests that a pattern occurs in. @param {RegExp} pattern */
function filesThatName(pattern) {
  const places = [...SOURCE, 'capi/include', 'docs'].filter((folder) => existsSync(path.join(ROOT, folder))).flatMap(filesIn);
  const named = places.filter(
    (file) => !isTest(file) && !file.startsWith('docs/api/') && /\.(rs|js|mjs|ts|pyi?|md|json|html|h|txt)$/.test(file),
  );
  return named.filter((file) => pattern.test(read(file))).length;
}

/** Seconds of the first build of the command, and of one after a change of each file. @returns {Promise<[string, string][]>} */
async function builds() {
  const target = mkdtempSync(path.join(tmpdir(), 'hexcast-weight-'));
  const seconds = async () => {
    const start = performance.now();
    await run('cargo', ['build', '--release', '--package', 'hexcast'], { env: { CARGO_TARGET_DIR: target } });
    return `${((performance.now() - start) / 1000).toFixed(0)} s`;
  };
  /** @type {[string, string][]} */
  const rows = [];
  try {
    rows.push(['first build of the command', await seconds()]);
    // what nothing stands on first: each build also compiles what the one before had changed
    const files = [
      'src/bin/hexcast/main.rs',
      'src/meshing/pipeline.rs',
      'crates/files/src/write/raw.rs',
      'crates/core/src/stages/map.rs',
    ];
    for (const file of files) {
      const text = read(file);
      try {
        // an item that the compiler must look at
        appendFileSync(path.join(ROOT, file), '\nconst _: u8 = 0;\n');
        rows.push([`build after a change of ${file}`, await seconds()]);
      } finally {
        writeFileSync(path.join(ROOT, file), text);
      }
    }
  } finally {
    rmSync(target, { recursive: true, force: true });
  }
  return rows;
}

/** What is counted, as rows. @returns {[string, string][]} */
export function counted() {
  const rust = ['src', 'crates', 'capi/src', 'python/src'].flatMap(filesIn).filter((file) => file.endsWith('.rs'));
  const page = filesIn('www/page').filter((file) => file.endsWith('.js'));
  const scripts = filesIn('www').filter((file) => /\.(js|d\.ts)$/.test(file) && !page.includes(file));
  const wheel = filesIn('python/package').filter((file) => /\.pyi?$/.test(file));
  const [[folder, entries]] = byEntries(SOURCE);
  return [
    ['compiled dependencies of the default build', `${dependencies()}`],
    ['Rust lines that are code, without tests', `${codeOf(rust)}`],
    ['JavaScript and Python lines of package and wheel', `${codeOf([...scripts, ...wheel])}`],
    ['JavaScript lines of the page', `${codeOf(page)}`],
    ['entries in the largest source folder', `${entries} (${folder})`],
    ['files that name the option close_gaps', `${filesThatName(OPTION)}`],
    ['files that name the format binvox', `${filesThatName(FORMAT)}`],
  ];
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const rows = counted();
  if (process.argv.includes('--builds')) rows.push(...(await builds()));
  for (const [what, figure] of rows) console.log(`${what.padEnd(52)} ${figure}`);
}
