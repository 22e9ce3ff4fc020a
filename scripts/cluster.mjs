// The cluster tests: windows of one mesh by many processes, on S3, and by the scripts for Slurm and Kubernetes.

import { copyFileSync, mkdirSync } from 'node:fs';
import path from 'node:path';

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
  await run('cargo', args, { minutes: 30, env: { CARGO_TARGET_DIR: path.join(FOLDER, 'target') } });
  return 'compiled';
}

/** Builds the command with S3, and puts it in a folder of its own: other tests use the command without. */
export async function buildCluster() {
  await run('cargo', ['build', '--bin', 'hexcast', '--features', 's3'], { minutes: 30 });
  mkdirSync(path.join(ROOT, 'target/s3'), { recursive: true });
  copyFileSync(path.join(ROOT, 'target/debug/hexcast'), path.join(ROOT, 'target/s3/hexcast'));
}

/** Runs the tests; returns what they printed, the counts at their end. */
export async function runCluster() {
  const pytest = path.join(ROOT, '.tools/python/bin/pytest');
  return run(pytest, ['tests/cluster', '-q', '-rfEP', '--durations=0'], { env: { HEXCAST_S3_SERVER: SERVER }, minutes: 15 });
}
