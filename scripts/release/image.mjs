// The image of the command: its file is linted, and where Docker runs the image is built of the archive, weighed and used.

import { readFileSync, readdirSync } from 'node:fs';
import path from 'node:path';

import { ROOT, ask, run } from '../run.mjs';
import { IS_LINUX, OUT, TRIPLE, opened } from './build.mjs';
import { cubeFile } from './cube.mjs';
import { program } from './tools.mjs';
import { version } from './versions.mjs';

/** @typedef {import('./release.mjs').Artefact} Artefact */

const FILE = 'scripts/release/Dockerfile';
/** Most megabytes of the image, without compression. */
const MOST_MB = 60;
const TAG = 'hexcast-command';

/** What is wrong with a file of an image that strangers run: a sentence each. @param {string} text @returns {string[]} */
export function imageFaults(text) {
  const lines = text
    .replaceAll('\\\n', ' ')
    .split('\n')
    .map((line) => line.trim());
  const froms = lines.filter((line) => /^FROM /i.test(line)).map((line) => line.split(/\s+/)[1]);
  const last = lines.slice(lines.findLastIndex((line) => /^FROM /i.test(line)));
  const user = last
    .filter((line) => /^USER /i.test(line))
    .at(-1)
    ?.split(/\s+/)[1];
  return [
    ...(froms.length === 0 ? ['it has no FROM'] : []),
    ...froms.filter((name) => !/:[\w.-]+$/.test(name) || /:latest$/.test(name)).map((name) => `FROM ${name} names no version`),
    ...(user === undefined || /^(root|0)(:|$)/.test(user) ? [`it runs as ${user ?? 'root'}`] : []),
    ...lines.filter((line) => /^ADD /i.test(line)).map((line) => `COPY does what is wanted of "${line}"`),
    ...(last.some((line) => /^ENTRYPOINT \[/i.test(line)) ? [] : ['it has no ENTRYPOINT without a shell']),
  ];
}

/** Lints the file, and builds and tests the image where Docker runs. @returns {Promise<Artefact[]>} */
export async function makeImage() {
  if (!IS_LINUX) throw new Error(`the image is made on Linux, not on ${process.platform}`);
  const faults = imageFaults(readFileSync(path.join(ROOT, FILE), 'utf8'));
  if (faults.length > 0) throw new Error(`${FILE}: ${faults.join('; ')}`);
  await run(program('hadolint'), [FILE, 'Dockerfile']);
  const hasDocker = ask('docker', ['version', '--format', '{{.Server.Version}}']) !== null;
  if (!hasDocker && process.env.CI) throw new Error('no Docker runs here, which the image is built with');
  const row = { file: `image of ${FILE}`, tag: 'distroless, not root' };
  if (!hasDocker) return [{ ...row, test: 'linted by hadolint; NOT BUILT: no Docker runs here' }];
  return [{ ...row, ...(await built()) }];
}

/** Builds the image of the archive that was made before. */
async function built() {
  const wanted = `hexcast-${version()}-${TRIPLE}.tar.gz`;
  if (!readdirSync(OUT).includes(wanted))
    throw new Error(`the image is made of ${wanted}, which is not there: make "command", too`);
  await run('docker', ['build', '--file', FILE, '--tag', TAG, await opened(path.join(OUT, wanted))]);
  const size = Number(ask('docker', ['image', 'inspect', '--format', '{{.Size}}', TAG]));
  if (!(size > 0 && size < MOST_MB * 1e6)) throw new Error(`the image has ${(size / 1e6).toFixed(1)} MB, of ${MOST_MB}`);
  const user = ask('docker', ['image', 'inspect', '--format', '{{.Config.User}}', TAG]);
  if (!user || /^(root|0)$/.test(user)) throw new Error(`the image runs as ${user || 'root'}`);
  const file = cubeFile('cube-of-image');
  const mount = ['--rm', '--read-only', '--network', 'none', '--volume', `${path.dirname(file)}:/work:ro`];
  const report = JSON.parse(
    await run('docker', ['run', ...mount, TAG, 'mesh', 'cube.stl', '--cells', '10', '--backend', 'cpu', '--json']),
  );
  if (report.flags[0].cells !== 1000) throw new Error(`a cube has ${report.flags[0].cells} cells in the image, not 1000`);
  return { size, test: 'linted by hadolint; built; a cube has 1000 cells, as another user than root, on a read-only disk' };
}
