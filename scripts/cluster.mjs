// The cluster tests: windows of one mesh by many processes, on S3, and by the scripts for Slurm and Kubernetes.

import path from 'node:path';

import { buildNative } from './native.mjs';
import { ROOT, ask, isExecutable, run } from './run.mjs';

const VERSION = '0.14.1';
const FOLDER = path.join(ROOT, '.tools/s3s');
/** A server of S3 on folders, from crates.io. */
const SERVER = path.join(FOLDER, 'bin/s3s-fs');

/** Compiles the server that the tests of S3 start, in some three minutes of a processor. */
export async function ensureS3() {
  if (isExecutable(SERVER) && ask(SERVER, ['--version'])?.endsWith(VERSION)) return null;
  const args = [
    'install',
    's3s-fs',
    '--version',
    VERSION,
    '--locked',
    '--debug',
    '--features',
    'binary',
    '--root',
    FOLDER,
    '--force',
  ];
  await run('cargo', args, { env: { CARGO_TARGET_DIR: path.join(FOLDER, 'target') } });
  return 'compiled';
}

/** Runs the tests; returns what they printed, the counts at their end. */
export async function runCluster() {
  const pytest = path.join(ROOT, '.tools/python/bin/pytest');
  const env = { HEXCAST_S3_SERVER: SERVER, HEXCAST_COMMAND: await buildNative() };
  return run(pytest, ['tests/cluster', '-q', '-rfEP', '--durations=0'], { env });
}
