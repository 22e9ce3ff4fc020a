// Before all tests of the page: builds the native command that they compare it with.

import { run } from '../../scripts/run.mjs';

export default async function setup() {
  await run('cargo', ['build', '--bin', 'hexcast']);
}
