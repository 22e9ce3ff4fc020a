// The two browsers of the page tests, headless, each with WebGPU on a software driver: Chromium (Tint, on SwiftShader)
// and Firefox (naga, on lavapipe).

import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { chromium as playwright } from '@playwright/test';
import puppeteer from 'puppeteer-core';

import { chromium, firefox } from '../../scripts/machine.mjs';

/** Of every Chromium that tests start. */
export const CHROMIUM_ARGS = [
  '--no-sandbox',
  '--disable-dev-shm-usage',
  '--disable-background-networking',
  '--disable-component-update',
  '--enable-unsafe-webgpu',
  '--use-webgpu-adapter=swiftshader',
];
const FIREFOX_PREFS = {
  'dom.webgpu.enabled': true,
  'dom.webgpu.workers.enabled': true,
  'gfx.webgpu.ignore-blocklist': true,
};

/** Before the page's scripts: the user has switched off that the page meshes whatever changes. */
export function meshByClick() {
  // an empty page has no storage
  if (location.protocol !== 'about:') localStorage.setItem('hexcast-live', 'off');
}

/** Starts Chromium; resolves to a Playwright browser. @param {string[]} [args] */
export function openChromium(args = []) {
  return playwright.launch({ executablePath: chromium() ?? undefined, args: [...CHROMIUM_ARGS, ...args] });
}

/**
 * Starts Chromium with a profile in a folder, which has room for large files; resolves to a Playwright context.
 *
 * @param {string} folder
 * @param {string[]} [args]
 */
export function openChromiumProfile(folder, args = []) {
  return playwright.launchPersistentContext(folder, {
    executablePath: chromium() ?? undefined,
    args: [...CHROMIUM_ARGS, ...args],
  });
}

/** Starts Firefox with a profile of its own; resolves to a Puppeteer browser. */
export async function openFirefox() {
  const profile = mkdtempSync(path.join(tmpdir(), 'hexcast-firefox-'));
  const browser = await puppeteer.launch({
    browser: 'firefox',
    executablePath: firefox() ?? undefined,
    headless: true,
    userDataDir: profile,
    extraPrefsFirefox: FIREFOX_PREFS,
    // as root its content sandbox cannot reach the driver
    env: { ...process.env, MOZ_DISABLE_CONTENT_SANDBOX: '1' },
  });
  browser.process()?.once('exit', () => rmSync(profile, { recursive: true, force: true }));
  return browser;
}

/**
 * Collects what must stay empty: errors and warnings on the console, uncaught errors, failed requests, and requests to
 * another origin. Works on pages of both browsers.
 *
 * @param {any} page Playwright's or Puppeteer's: what is used of it is the same
 * @param {string} url
 * @returns {string[]} grows as the page lives
 */
export function complaintsOf(page, url) {
  /** @type {string[]} */
  const complaints = [];
  const { origin } = new URL(url);
  page.on('console', (/** @type {{ type(): string, text(): string }} */ message) => {
    if (['error', 'warning', 'warn'].includes(message.type())) complaints.push(`console: ${message.text()}`);
  });
  page.on('pageerror', (/** @type {Error} */ error) => complaints.push(`uncaught: ${error.message}`));
  page.on('requestfailed', (/** @type {{ url(): string }} */ request) => complaints.push(`failed: ${request.url()}`));
  page.on('request', (/** @type {{ url(): string }} */ request) => {
    const target = new URL(request.url());
    const isLocal = target.origin === origin || ['data:', 'blob:'].includes(target.protocol);
    if (!isLocal) complaints.push(`another origin: ${target.href}`);
  });
  page.on('response', (/** @type {{ url(): string, status(): number }} */ response) => {
    if (response.status() >= 400) complaints.push(`status ${response.status()}: ${response.url()}`);
  });
  return complaints;
}
