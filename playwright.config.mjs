// The tests of the page, by Playwright in the Chromium that this machine has; Firefox is driven by Puppeteer from within them.

import { defineConfig } from '@playwright/test';

import { chromium } from './scripts/machine.mjs';
import { CHROMIUM_ARGS } from './tests/e2e/browsers.mjs';

export default defineConfig({
  testDir: 'tests/e2e',
  testMatch: '*.test.mjs',
  outputDir: 'target/e2e',
  // one picture for all systems: the tests are run on Debian
  snapshotPathTemplate: '{testDir}/pictures/{arg}{ext}',
  // a missing picture is a failure, and not a new one
  updateSnapshots: 'none',
  // the GPU is the processor here: two tests at once would take each other's time
  workers: 1,
  forbidOnly: true,
  timeout: 240_000,
  reporter: [['list'], ['json', { outputFile: 'target/e2e.json' }]],
  use: {
    // the 3-D view is drawn on the processor here
    launchOptions: { executablePath: chromium() ?? undefined, args: [...CHROMIUM_ARGS, '--enable-unsafe-swiftshader'] },
  },
});
