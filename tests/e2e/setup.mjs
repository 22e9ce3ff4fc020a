// Before all tests of the page: builds the native command that they compare it with.

import { run } from '../../scripts/run.mjs';

export default async function setup() {
  // as the native tests build it: by itself it would be compiled again, as dependencies of tests switch on features of others
  await run('cargo', ['test', '--test', 'native', '--no-run'], { minutes: 30 });
}
