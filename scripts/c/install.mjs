// What the C library installs: programs are built with it by CMake, by pkg-config and by the commands of its README; and the names of files on
// other systems.

import { cpSync, existsSync, lstatSync, mkdirSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { CAPI, FOLDER, compiled, equal, filesOf, fresh, pkgConfig, prefix } from './library.mjs';
import { commandPath } from '../native.mjs';
import { version } from '../release/versions.mjs';
import { run } from '../run.mjs';

/** The version, and that of the interface: before 1.0 a minor version may change it. */
const VERSION = version();
const INTERFACE = VERSION.replace(/\.\d+(-.*)?$/, '');
const [MAJOR, MINOR, PATCH] = VERSION.split(/[.-]/).map(Number);

/** Builds programs by CMake, and by pkg-config with the static library, and runs them. */
export async function testInstall() {
  const folder = await prefix();
  const build = fresh('cmake');
  const project = path.join(CAPI, 'tests/cmake');
  const libdir = pkgConfig('--variable=libdir')[0];
  const found = `-Dhexcast_DIR=${path.join(libdir, 'cmake/hexcast')}`;
  await run('cmake', ['-S', project, '-B', build, found]);
  await run('cmake', ['--build', build]);
  const box = '14 x 14 x 14 cells, 1000 inside\n';
  for (const name of ['box_shared', 'box_static']) equal(await run(path.join(build, name), []), box);
  equal(await run(path.join(build, 'version'), []), `${pkgConfig('--modversion')[0]}\n`);
  await testRuns(path.join(build, 'runs'));
  await testRuns(await compiled('gfortran', 'examples/runs.f90'));

  await testReadme(box);
  const needs = /NEEDED.*hexcast\.so\.(\d+\.\d+)\]/;
  const of = async (/** @type {string} */ name) => needs.exec(await run('readelf', ['-d', path.join(build, name)]))?.[1];
  const [shared, archive] = [await of('box_shared'), await of('box_static')];
  if (shared !== pkgConfig('--modversion')[0].replace(/\.\d+$/, '') || archive)
    throw new Error(`linked with ${shared} and ${archive}`);

  // versions that fit, and that do not
  for (const [wanted, fits] of /** @type {[string, boolean][]} */ ([
    [VERSION, true],
    [`${MAJOR}`, true],
    [`${MAJOR}.${MINOR + 1}`, false],
    [`${INTERFACE}.${PATCH + 1}`, false],
    [`${MAJOR + 1}`, false],
  ])) {
    const asking = fresh('asking');
    const text = `cmake_minimum_required(VERSION 3.16)\nproject(a LANGUAGES C)\nfind_package(hexcast ${wanted} REQUIRED)\n`;
    writeFileSync(path.join(asking, 'CMakeLists.txt'), text);
    const done = await run('cmake', ['-S', asking, '-B', path.join(asking, 'build'), found]).then(
      () => true,
      () => false,
    );
    if (done !== fits) throw new Error(`find_package(hexcast ${wanted}) ${done ? 'succeeded' : 'failed'}`);
  }
  return `${readdirSync(folder).length} folders of a prefix that was moved`;
}

/** Runs the commands of the README, and its lines of C. @param {string} box what the example prints */
async function testReadme(box) {
  const text = readFileSync(path.join(CAPI, 'README.md'), 'utf8');
  const cwd = fresh('readme');
  cpSync(path.join(CAPI, 'examples/box.c'), path.join(cwd, 'solver.c'));
  cpSync(path.join(CAPI, 'examples/runs.f90'), path.join(cwd, 'solver.f90'));
  const commands = text.replaceAll('\\\n', '').match(/^ {4}(cc|gfortran) .*$/gm) ?? [];
  if (commands.length !== 3) throw new Error(`the README has ${commands.length} commands that compile`);
  for (const command of commands) {
    await run('sh', ['-c', command], { cwd });
    if (command.includes('gfortran')) await testRuns(path.join(cwd, 'solver'));
    else equal(await run(path.join(cwd, 'solver'), []), box);
  }
  const lines = /```c\n([^`]+)```/.exec(text)?.[1] ?? '';
  const example = readFileSync(path.join(CAPI, 'examples/box.c'), 'utf8');
  const program = example.replace(
    '  const uint32_t first',
    `${lines}\n  printf("%llu by runs\\n", (unsigned long long)n_solid);\n  const uint32_t first`,
  );
  writeFileSync(path.join(cwd, 'solver.c'), program);
  await run('sh', ['-c', commands[0]], { cwd });
  equal(await run(path.join(cwd, 'solver'), []), `1000 by runs\n${box}`);
}

/** Runs the example that counts by runs, and has the command read what it writes. @param {string} program */
async function testRuns(program) {
  const file = path.join(FOLDER, 'cube.hxc');
  equal(await run(program, [file]), '1000 cells inside, 1744 outside\n');
  const [{ cells, flags }] = JSON.parse(await run(await commandPath(), ['info', file, '--json']));
  const read = [cells, flags.length, flags[0].flag, flags[0].cells];
  if (String(read) !== '2744,1,7,1000') throw new Error(`the command reads ${read}`);
}

/** The files that are installed below a prefix for other systems; links have an arrow. @type {Record<string, string[]>} */
const NAMES = {
  'aarch64-apple-darwin': [
    `lib/libhexcast.${VERSION}.dylib`,
    `lib/libhexcast.${INTERFACE}.dylib ->`,
    'lib/libhexcast.a',
    'lib/libhexcast.dylib ->',
  ],
  'x86_64-pc-windows-msvc': ['bin/hexcast.dll', 'lib/hexcast.lib', 'lib/hexcast_static.lib'],
  'x86_64-pc-windows-gnu': ['bin/hexcast.dll', 'lib/libhexcast.a', 'lib/libhexcast.dll.a'],
  'x86_64-unknown-linux-gnu': [
    'lib/libhexcast.a',
    'lib/libhexcast.so ->',
    `lib/libhexcast.so.${INTERFACE} ->`,
    `lib/libhexcast.so.${VERSION}`,
  ],
};

/** Checks the names of files for other systems, with a cargo that only makes empty files of the names that the real one gives. */
export async function testNames() {
  const folder = fresh('names');
  mkdirSync(path.join(folder, 'bin'));
  const cargo = `#!/bin/sh
case $* in
  metadata*) echo '{"target_directory":"${folder}"}' ;;
  *failing*) echo 'error: no such target' >&2; exit 101 ;;
  *) case $* in
      *darwin*) files='libhexcast.dylib libhexcast.a' needs='-framework Metal -lobjc' ;;
      *msvc*) files='hexcast.dll hexcast.lib hexcast.dll.lib' needs='kernel32.lib ws2_32.lib' ;;
      *windows-gnu*) files='hexcast.dll libhexcast.a libhexcast.dll.a' needs='-lkernel32 -lws2_32' ;;
      *) files='libhexcast.so libhexcast.a' needs='-lm -lc' ;;
    esac
    for target in ${Object.keys(NAMES).join(' ')}; do
      case $* in *$target*) mkdir -p "${folder}/$target/release" && cd "${folder}/$target/release" && touch $files ;; esac
    done
    echo "note: native-static-libs: $needs" >&2 ;;
esac
`;
  writeFileSync(path.join(folder, 'bin/cargo'), cargo, { mode: 0o755 });
  const env = { PATH: `${path.join(folder, 'bin')}:${process.env.PATH}`, DESTDIR: path.join(folder, 'root') };
  const script = path.join(CAPI, 'install.sh');
  for (const [target, expected] of Object.entries(NAMES)) {
    await run('sh', [script, '--prefix', `/${target}`, '--target', target], { env });
    const root = path.join(env.DESTDIR, target);
    const isLink = (/** @type {string} */ name) => lstatSync(path.join(root, name)).isSymbolicLink();
    const libraries = filesOf(root).filter((name) => /^(bin|lib)\/[^/]+$/.test(name));
    equal(libraries.map((name) => (isLink(name) ? `${name} ->` : name)).join('\n'), expected.join('\n'));
    // what CMake is told to link is there
    const config = readFileSync(path.join(root, 'lib/cmake/hexcast/hexcast-config.cmake'), 'utf8');
    const named = [...config.matchAll(/"\$\{_hexcast_prefix\}\/((?:bin|lib)\/[^"]+)"/g)].map(([, name]) => name);
    const missing = named.filter((name) => !libraries.includes(name));
    if (named.length < 2 || missing.length > 0) throw new Error(`${target}: CMake would look for ${missing} of ${named}`);
    if (target.includes('apple') && !config.includes('"-framework Metal;-lobjc"')) throw new Error(`frameworks: ${config}`);
  }
  const refused = /** @type {[string[], string][]} */ ([
    [[], 'say where to install'],
    [['--prefix', '/p', '--static'], 'there is no argument --static'],
    [['--prefix'], '--prefix needs a value'],
    [['--prefix', '/p', '--libdir', '../lib'], 'not the name of a folder'],
    [['--prefix', '/p', '--target', 'failing'], 'no such target'],
    [['--prefix', '/p', '--target', 'aarch64-apple-darwin', '--built', folder], '--built is for Linux'],
    [['--prefix', '/p', '--built', folder], 'the library was not built'],
  ]);
  for (const [words, part] of refused) {
    const said = await run('sh', [script, ...words], { env }).then(
      () => 'done',
      (failed) => failed.output,
    );
    if (!said.includes(part))
      throw Object.assign(new Error(`install.sh ${words.join(' ')} did not say "${part}"`), { output: said });
  }
  if (existsSync(path.join(env.DESTDIR, 'p'))) throw new Error('something was installed after an error');
  return `${Object.keys(NAMES).length} systems`;
}
