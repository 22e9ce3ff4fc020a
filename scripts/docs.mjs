// npm run docs: makes target/docs-site, a site with search of the pages in docs/ and of those that docs/SUMMARY.md names elsewhere.
//
// mdBook takes pages of one folder only. So all pages are copied to one first: those of docs/ as they lie there, other files of the
// repository below `repository/`. Links and pictures are rewritten to these places. Source files and folders that a page links to become
// pages, too, listed at the end. A link of the site that leads nowhere is a failure.

import { cpSync, existsSync, mkdirSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { linksOf, withLinks } from './links.mjs';
import { ROOT, ask, run } from './run.mjs';

const VERSION = '0.5.4';
const TOOLS = path.join(ROOT, '.tools');
const TOOL = path.join(TOOLS, 'bin/mdbook');
const BOOK = path.join(ROOT, 'target/docs-book');
const SITE = path.join(ROOT, 'target/docs-site');
/** What a browser shows as it is, or mdBook makes a page of; all else becomes a page with its text. */
const AS_IT_IS = /\.(md|json|txt|svg|png)$/;
/** The word after the fence of a block of code, by the ending of a file. @type {Record<string, string>} */
const LANGUAGES = {
  js: 'js',
  mjs: 'js',
  rs: 'rust,noplayground',
  html: 'html',
  py: 'python',
  ts: 'ts',
  yaml: 'yaml',
  sh: 'sh',
  c: 'c',
  f90: 'fortran',
};
const SETTINGS = `[book]
title = "hexcast"
description = "Exact Cartesian meshing of closed surfaces"
language = "en"

[output.html]
smart-punctuation = false
no-section-label = true
additional-css = ["wide.css"]

[output.html.playground]
runnable = false

[output.html.search]
limit-results = 30
`;

/** Commands and tables of the documents are wider than the columns of mdBook. */
const STYLE = ':root { --content-max-width: 1150px; }\n';

/** Installs mdBook once, with search and without a server. */
async function ensureBook() {
  if (ask(TOOL, ['--version']) === `mdbook v${VERSION}`) return;
  console.log(`compiles mdBook ${VERSION} ...`);
  const features = ['--no-default-features', '--features', 'search'];
  await run('cargo', ['install', 'mdbook', '--version', VERSION, '--locked', ...features, '--root', TOOLS, '--force']);
}

/** Place of a file or folder of the repository in the book. @param {string} file path in the repository */
function placeOf(file) {
  const within = file.startsWith('docs/') ? file.slice('docs/'.length) : `repository/${file}`;
  // mdBook calls a README so, but leaves links to it as they are
  return AS_IT_IS.test(file) ? within.replace(/README\.md$/, 'index.md') : `${within}.md`;
}

/** Copies pages, and what they link to, into the book. */
class Pages {
  #seen = new Set();
  /** Pages that SUMMARY.md does not name: source files and folders. @type {string[]} */
  extra = [];

  /** @param {string} file path in the repository */
  add(file) {
    if (this.#seen.has(file)) return;
    this.#seen.add(file);
    const from = path.join(ROOT, file);
    const to = path.join(BOOK, 'src', placeOf(file));
    mkdirSync(path.dirname(to), { recursive: true });
    if (file.endsWith('.md')) writeFileSync(to, this.#rewritten(file));
    else if (AS_IT_IS.test(file)) cpSync(from, to);
    else {
      this.extra.push(file);
      writeFileSync(to, statSync(from).isDirectory() ? this.#folder(file) : source(file));
    }
  }

  /** A page with the links that it has in the book. @param {string} file */
  #rewritten(file) {
    return withLinks(readFileSync(path.join(ROOT, file), 'utf8'), (link) => {
      const [target, anchor] = link.split('#');
      if (/^[a-z]+:/.test(link) || target === '') return link;
      let meant = path.posix.join(path.posix.dirname(file), target).replace(/\/$/, '');
      const readme = `${meant}/README.md`;
      if (existsSync(path.join(ROOT, readme))) meant = readme;
      this.add(meant);
      const relative = path.posix.relative(path.posix.dirname(placeOf(file)), placeOf(meant));
      return anchor ? `${relative}#${anchor}` : relative;
    });
  }

  /** A page that lists the files of a folder. @param {string} folder */
  #folder(folder) {
    const names = readdirSync(path.join(ROOT, folder)).filter((name) => statSync(path.join(ROOT, folder, name)).isFile());
    const items = names.map((name) => {
      const file = `${folder}/${name}`;
      this.add(file);
      return `- [${name}](${path.posix.relative(path.posix.dirname(placeOf(folder)), placeOf(file))})`;
    });
    return `# ${folder}\n\n${items.join('\n')}\n`;
  }
}

/** A source file as a page. @param {string} file */
function source(file) {
  const text = readFileSync(path.join(ROOT, file), 'utf8');
  return `# ${file}\n\n\`\`\`\`${LANGUAGES[path.extname(file).slice(1)] ?? 'text'}\n${text.trimEnd()}\n\`\`\`\`\n`;
}

/** Links of the site that lead to no file, or to no place of a page. @returns {string[]} */
function deadLinks() {
  const names = readdirSync(SITE, { recursive: true, encoding: 'utf8' });
  // print.html joins all pages, toc.html is part of each
  const pages = names.filter((name) => name.endsWith('.html') && !['print.html', 'toc.html', '404.html'].includes(name));
  const text = new Map(pages.map((name) => [name, readFileSync(path.join(SITE, name), 'utf8')]));
  return pages.flatMap((name) => {
    const links = [...(text.get(name) ?? '').matchAll(/<[a-z][^<>]* (?:href|src)="([^"]+)"/g)].map((match) =>
      decodeURI(match[1]),
    );
    const isDead = (/** @type {string} */ link) => {
      const [target, anchor] = link.split('#');
      const meant = target === '' ? name : path.join(path.dirname(name), target);
      if (!existsSync(path.join(SITE, meant))) return true;
      return Boolean(anchor) && text.has(meant) && !text.get(meant)?.includes(` id="${anchor}"`);
    };
    return links.filter((link) => !/^[a-z]+:/.test(link) && isDead(link)).map((link) => `${name}: ${link}`);
  });
}

await ensureBook();
for (const folder of [BOOK, SITE]) rmSync(folder, { recursive: true, force: true });
const pages = new Pages();
pages.add('docs/SUMMARY.md');
const summary = path.join(BOOK, 'src/SUMMARY.md');
const files = pages.extra.sort().map((file) => `- [${file}](${placeOf(file)})\n`);
writeFileSync(summary, `${readFileSync(summary, 'utf8')}\n# Source files\n\n${files.join('')}`);
writeFileSync(path.join(BOOK, 'book.toml'), SETTINGS);
writeFileSync(path.join(BOOK, 'wide.css'), STYLE);
await run(TOOL, ['build', BOOK, '--dest-dir', SITE]);
const dead = deadLinks();
if (dead.length > 0) throw new Error(`links that lead nowhere:\n${dead.join('\n')}`);
console.log(`${linksOf(readFileSync(summary, 'utf8')).length} pages in target/docs-site`);
