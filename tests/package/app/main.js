// What a page does with the package; the test reads `globalThis.outcome`. `?backend=cpu` asks for a backend.
import { HexcastError, createMesher, version } from 'hexcast';

async function meshSpot() {
  const source = await (await fetch('spot.stl')).blob();
  const backend = new URLSearchParams(location.search).get('backend') ?? 'auto';
  const mesher = await createMesher({ backend });
  const job = { geometries: [{ source, file: 'spot.stl', name: 'cow', flag: 7 }], cells: 40, unit: 'mm' };
  const mesh = await mesher.mesh(job);
  const code = await mesher.mesh({ ...job, dims: [1, 1, 1] }).catch((error) => (error instanceof HexcastError ? error.code : String(error)));
  const outcome = { version, backend: mesher.backend, dims: mesh.dims, flags: mesh.report.flags, sha256: await mesh.sha256(), code };
  mesher.dispose();
  return outcome;
}

try {
  globalThis.outcome = await meshSpot();
} catch (error) {
  globalThis.outcome = { failed: `${error.name} ${error.code}: ${error.message}\n${error.stack}` };
}
