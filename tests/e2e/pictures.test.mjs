// Pictures of the page: on a phone, a tablet, a laptop and a large screen, in light, dark and forced colours, beside golden ones.
//
// Write them again with "npx playwright test pictures -g 'looks as it did' --update-snapshots", and look at the difference.

import assert from 'node:assert/strict';

import { expect } from '@playwright/test';

import { OPEN_BOX } from './open_box.mjs';
import { cellsAreDrawn, hasGeometries, isIdle, run, take, test } from './visit.mjs';

const SCREENS = {
  phone: { width: 390, height: 844 },
  tablet: { width: 820, height: 1180 },
  laptop: { width: 1280, height: 800 },
  large: { width: 2560, height: 1440 },
};
const COLOURS = {
  light: { colorScheme: 'light', forcedColors: 'none' },
  dark: { colorScheme: 'dark', forcedColors: 'none' },
  forced: { colorScheme: 'light', forcedColors: 'active' },
};
/** A shifted panel differs in more pixels than letters that another version of the browser draws. */
const TOLERANCE = { threshold: 0.3, maxDiffPixelRatio: 0.004 };

/** What a test needs to bring the page there, and whether the canvas has a picture of WebGL. */
const STATES = {
  empty: { go: async () => {} },
  models: { go: (page) => take(page, 'cubes', 2), isDrawn: true },
  mesh: { go: mesh, isDrawn: true },
  slices: {
    go: async (page) => {
      await mesh(page);
      await page.check('#panes-z');
      await page.waitForSelector('#canvas-z[data-axis]');
    },
  },
  findings: {
    go: async (page) => {
      await page.setInputFiles('#file-input', { name: 'box.stl', mimeType: 'model/stl', buffer: Buffer.from(OPEN_BOX) });
      await hasGeometries(page, 1);
      await run(page);
      await page.click('#finding-next');
    },
    isDrawn: true,
  },
  error: {
    go: async (page) => {
      await page.setInputFiles('#file-input', { name: 'letter.stl', mimeType: 'model/stl', buffer: Buffer.from('Dear Sir') });
      await page.waitForSelector('#messages [role=alert]');
      await isIdle(page);
    },
  },
};

async function mesh(page) {
  await take(page, 'cubes', 2);
  await run(page);
  await cellsAreDrawn(page);
}

/** Shows the page on a screen; what differs from run to run and from machine to machine is set to the same words. */
async function show(page, screen, colours) {
  await page.emulateMedia({ ...COLOURS[colours], reducedMotion: 'reduce' });
  await page.setViewportSize(SCREENS[screen]);
  // over nothing that looks another way then
  await page.mouse.move(0, 0);
  await page.evaluate(async () => {
    const words = { version: '0.0.0', device: 'Processor', status: 'Ready.', 'estimate-time': 'about 1 s' };
    for (const [id, text] of Object.entries(words)) {
      const element = document.getElementById(id);
      if (element) element.textContent = text;
    }
    // which every Debian with a browser has
    document.documentElement.style.fontFamily = '"DejaVu Sans", sans-serif';
    for (const field of document.querySelectorAll('dt'))
      if (field.textContent === 'Time') field.nextElementSibling.textContent = '1 s';
    document.activeElement?.blur();
    scrollTo(0, 0);
    // the slice is drawn anew where its stage changed
    for (let frame = 0; frame < 3; frame += 1) await new Promise(requestAnimationFrame);
  });
}

/** The screens and colours of a state: all of the mesh, fewer of the others, as pictures are large. */
function looksOf(state) {
  const screens = Object.keys(SCREENS);
  if (state === 'mesh') return screens.flatMap((screen) => Object.keys(COLOURS).map((colours) => [screen, colours]));
  const lit = state === 'empty' ? screens : ['phone', 'tablet', 'laptop'];
  return [...lit.map((screen) => [screen, 'light']), ['laptop', 'dark'], ['laptop', 'forced']];
}

for (const [state, { go, isDrawn = false }] of Object.entries(STATES)) {
  test(`the page looks as it did: ${state}`, async ({ visit }) => {
    const page = await visit('#cells=24&backend=cpu');
    await page.setViewportSize(SCREENS.laptop);
    await go(page);
    for (const [screen, colours] of looksOf(state)) {
      await show(page, screen, colours);
      // what WebGL draws is tested by its pixels elsewhere
      const mask = isDrawn ? [page.locator('#canvas-3d')] : [];
      await expect.soft(page).toHaveScreenshot(`${state}-${screen}-${colours}.png`, { ...TOLERANCE, mask });
    }
  });
}

/** Panels of which something is seen on a screen. */
const PANELS = {
  phone: ['header', '#view'],
  tablet: ['#run-bar', '#pane-3d'],
  laptop: ['.results', '#run-bar', '.scroll'],
  large: ['.results'],
};

test('a panel that is moved by 8 pixels is seen on every screen', async ({ visit }) => {
  const page = await visit('#cells=24&backend=cpu');
  await page.setViewportSize(SCREENS.laptop);
  await mesh(page);
  const mask = [page.locator('#canvas-3d')];
  const move = (panel, by) =>
    page
      .locator(panel)
      .first()
      .evaluate((element, by) => (element.style.transform = by), by);
  for (const [screen, panels] of Object.entries(PANELS)) {
    for (const panel of panels) {
      await show(page, screen, 'light');
      const picture = () => expect(page).toHaveScreenshot(`mesh-${screen}-light.png`, { ...TOLERANCE, mask, timeout: 3000 });
      await move(panel, 'translateY(8px)');
      await assert.rejects(picture, /pixels \(ratio/, `${panel}, ${screen}`);
      await move(panel, '');
      await picture();
    }
  }
});
