// What a machine must have: packages from npm, a C linker, a Vulkan driver, browsers, Python, a Rust for wasm32. Installs what is
// missing where it can (Debian, as root) and says what to install where it cannot; silent and quick where nothing is missing.

import { createHash } from 'node:crypto';
import { existsSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { ROOT, ask, isExecutable, run, which } from './run.mjs';

const NODE_MODULES = path.join(ROOT, 'node_modules');

/** Installs the packages of package-lock.json unless exactly these are there. */
export async function ensureNodeModules() {
  const lock = readFileSync(path.join(ROOT, 'package-lock.json'));
  const hash = createHash('sha256').update(lock).digest('hex');
  const stamp = path.join(NODE_MODULES, '.hexcast-lock');
  if (existsSync(stamp) && readFileSync(stamp, 'utf8') === hash) return null;
  await run('npm', ['ci', '--include=dev', '--no-audit', '--no-fund']);
  writeFileSync(stamp, hash);
  return 'installed';
}

/** Programs of Debian's Rust for wasm32, for machines where rustup cannot download its target. */
export const DEBIAN_RUST = {
  rustc: '/usr/bin/rustc',
  cargo: '/usr/bin/cargo',
  cargoClippy: '/usr/bin/cargo-clippy',
  linker: '/usr/bin/wasm-ld-19',
};

/** Where Linux has its libraries. */
const LIBRARIES = ['/lib', '/usr/lib', '/usr/lib64', '/usr/local/lib', `/usr/lib/${debianTriple()}`];

/** The list: how to see that a thing is there, the Debian packages that bring it, and what to call it. */
const NEEDS = {
  linker: { found: () => which('cc', 'gcc', 'clang'), packages: ['build-essential'], what: 'a C linker' },
  vulkan: { found: hasVulkan, packages: ['mesa-vulkan-drivers', 'libvulkan1'], what: 'a Vulkan driver such as lavapipe' },
  chromium: { found: chromium, packages: ['chromium'], what: 'Chromium, or CHROMIUM with its path' },
  firefox: { found: firefox, packages: ['firefox-esr'], what: 'Firefox, or FIREFOX with its path' },
  font: {
    found: () => ask('fc-match', ['DejaVu Sans', 'family']) === 'DejaVu Sans',
    packages: ['fontconfig', 'fonts-dejavu-core'],
    what: 'the font DejaVu Sans, of the pictures of the page',
  },
  python: {
    found: hasPython,
    packages: ['python3', 'python3-venv', 'python3-dev'],
    what: 'Python 3.10 or newer with venv, pip and its C headers, for which lbmpy compiles',
  },
  opengl: {
    found: hasEgl,
    packages: ['libegl1', 'libegl-mesa0', 'libgl1-mesa-dri'],
    what: 'OpenGL without a window (EGL), for PyVista',
  },
  mpi: {
    found: () => ['mpicc', 'mpirun'].every((name) => which(name)),
    packages: ['libopenmpi-dev', 'openmpi-bin'],
    what: 'OpenMPI',
  },
  openfoam: {
    found: () => ['checkMesh', 'simpleFoam', 'postProcess'].every((name) => which(name)),
    packages: ['openfoam'],
    what: 'OpenFOAM',
  },
  calculix: { found: () => which('ccx'), packages: ['calculix-ccx'], what: 'CalculiX' },
  gmsh: { found: () => which('gmsh'), packages: ['gmsh'], what: 'Gmsh' },
  openems: {
    found: () => which('openEMS') && imports('CSXCAD'),
    packages: ['openems', 'python3-openems'],
    what: 'openEMS with its Python module for /usr/bin/python3',
  },
  meep: { found: () => imports('meep'), packages: ['python3-meep'], what: 'Meep for /usr/bin/python3, of the benchmarks' },
  dolfinx: { found: () => imports('dolfinx'), packages: ['python3-dolfinx'], what: 'dolfinx for /usr/bin/python3' },
  taufactor: {
    found: () => ['torch', 'skimage', 'IPython', 'psutil', 'matplotlib'].every(imports),
    packages: ['python3-torch', 'python3-skimage', 'python3-ipython', 'python3-psutil', 'python3-matplotlib'],
    what: 'PyTorch and what else taufactor imports, for /usr/bin/python3',
  },
  palabos: {
    found: () => ['palabos/palabos3D.h', 'eigen3/Eigen/Core'].every((name) => existsSync(path.join('/usr/include', name))),
    packages: ['libplb-dev', 'libeigen3-dev', 'build-essential'],
    what: 'Palabos and Eigen in /usr/include',
  },
  fortran: { found: () => which('gfortran'), packages: ['gfortran'], what: 'gfortran' },
  cmake: { found: () => which('cmake') && which('make', 'ninja'), packages: ['cmake', 'make'], what: 'CMake' },
  pkgconfig: { found: () => which('pkg-config'), packages: ['pkg-config'], what: 'pkg-config' },
  valgrind: { found: () => which('valgrind'), packages: ['valgrind', 'libc6-dbg'], what: 'valgrind' },
  wasm32: {
    found: () => Object.values(DEBIAN_RUST).every(isExecutable),
    packages: ['rustc-web', 'cargo-web', 'rust-web-src', 'rust-web-clippy', 'lld-19'],
    what: 'a Rust for wasm32, which "rustup target add wasm32-unknown-unknown" brings too',
  },
};

/**
 * Installs these needs where they are missing.
 *
 * @param {(keyof typeof NEEDS)[]} names
 * @returns {Promise<string | null>} what was installed; rejects with a sentence that names what is missing
 */
export async function ensure(...names) {
  const missing = names.filter((name) => !NEEDS[name].found());
  if (missing.length === 0) return null;
  const packages = missing.flatMap((name) => NEEDS[name].packages);
  const installed = await installDebian(packages);
  const still = missing.filter((name) => !NEEDS[name].found());
  if (still.length > 0) {
    const what = still.map((name) => NEEDS[name].what).join('; ');
    throw new Error(`missing: ${what}. On Debian: apt-get install ${packages.join(' ')}`);
  }
  return installed;
}

/**
 * Installs Debian packages if this is Debian and we are root; else does nothing and resolves to null.
 *
 * @param {string[]} packages
 */
async function installDebian(packages) {
  if (!which('apt-get') || process.getuid?.() !== 0) return null;
  const env = { DEBIAN_FRONTEND: 'noninteractive' };
  await run('apt-get', ['update'], { env });
  await run('apt-get', ['install', '-y', '--no-install-recommends', ...packages], { env });
  return `installed ${packages.join(' ')}`;
}

/** Whether a Vulkan loader and at least one driver are there; systems with an interface of their own need none. */
function hasVulkan() {
  if (process.platform !== 'linux') return true;
  const folders = ['/usr/share/vulkan/icd.d', '/etc/vulkan/icd.d', '/usr/local/share/vulkan/icd.d'];
  const hasDriver =
    process.env.VK_DRIVER_FILES !== undefined || folders.some((folder) => existsSync(folder) && readdirSync(folder).length > 0);
  return hasDriver && LIBRARIES.some((folder) => existsSync(path.join(folder, 'libvulkan.so.1')));
}

/** Whether the Python of PATH can make virtual environments and compile extensions. */
function hasPython() {
  const looks = 'import ensurepip, os, sys, sysconfig, venv; print(sys.version_info >= (3, 10) and os.path.exists(os.path.join(';
  return ask('python3', ['-c', `${looks}sysconfig.get_paths()["include"], "Python.h")))`]) === 'True';
}

/** Whether the system's Python, for which Debian's packages are, has a module. @param {string} module */
function imports(module) {
  return ask('/usr/bin/python3', ['-c', `import ${module}; print(1)`])?.endsWith('1') ?? false;
}

function hasEgl() {
  if (process.platform !== 'linux') return true;
  return LIBRARIES.some(
    (folder) => existsSync(path.join(folder, 'libEGL.so.1')) && existsSync(path.join(folder, 'libEGL_mesa.so.0')),
  );
}

function debianTriple() {
  /** @type {Record<string, string>} */
  const triples = { x64: 'x86_64-linux-gnu', arm64: 'aarch64-linux-gnu' };
  return triples[process.arch] ?? process.arch;
}

/** Path of Chromium, or null. */
export function chromium() {
  return process.env.CHROMIUM ?? which('chromium', 'chromium-browser', 'google-chrome', 'chrome');
}

/** Path of Firefox, or null. */
export function firefox() {
  return process.env.FIREFOX ?? which('firefox-esr', 'firefox');
}

/** Environment that makes SwiftShader, which comes with Chromium, the only Vulkan driver; null if it is not where Debian has it. */
export function swiftshaderEnv() {
  const driver = '/usr/lib/chromium/vk_swiftshader_icd.json';
  return existsSync(driver) ? { VK_DRIVER_FILES: driver, VK_ICD_FILENAMES: driver } : null;
}

/** Fails with a sentence where there is no Rust. */
export function requireRust() {
  const version = ask('cargo', ['--version']);
  if (!version) throw new Error('missing: Rust, from https://rustup.rs');
  return version;
}
