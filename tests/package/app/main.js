// What a page does with the package; the test reads `globalThis.outcome`. `?backend=cpu&threads=2` asks for a backend and threads.
import { HexcastError, createMesher, version } from 'hexcast';
// the lines of the README of the package and of docs/libraries.md as they stand, after what they use
import './document_globals.js';
import './package_readme.js';
import './libraries.js';

async function meshSpot() {
  const source = await (await fetch('spot.stl')).blob();
  const asked = new URLSearchParams(location.search);
  const mesher = await createMesher({ backend: asked.get('backend') ?? 'auto', threads: Number(asked.get('threads') ?? 1) });
  const job = { geometries: [{ source, file: 'spot.stl', name: 'cow', flag: 7 }], cells: 40, unit: 'mm' };
  const mesh = await mesher.mesh(job);
  const code = await mesher
    .mesh({ ...job, dims: [1, 1, 1] })
    .catch((error) => (error instanceof HexcastError ? error.code : String(error)));
  const vti = await sha256(await mesh.blob('vti', { compress: 6 }));
  const again = await mesher.open(await mesh.blob('hxc', { compress: 6 }));
  const hashes = { sha256: await mesh.sha256(), again: await again.sha256(), vti };
  const { backend, threads } = mesher;
  const outcome = { version, backend, threads, dims: mesh.dims, flags: mesh.report.flags, ...hashes, code };
  mesher.dispose();
  return { ...outcome, cells: globalThis.cells };
}

async function sha256(blob) {
  const hash = await crypto.subtle.digest('SHA-256', await blob.arrayBuffer());
  return Array.from(new Uint8Array(hash), (byte) => byte.toString(16).padStart(2, '0')).join('');
}

try {
  globalThis.outcome = await meshSpot();
} catch (error) {
  globalThis.outcome = { failed: `${error.name} ${error.code}: ${error.message}\n${error.stack}` };
}
