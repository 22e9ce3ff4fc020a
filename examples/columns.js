/** Works on the runs of a mesh as they are, without its cells: node columns.js part.stl */
import { readFile } from 'node:fs/promises';
import { createMesher } from 'hexcast';

const mesher = await createMesher();
const mesh = await mesher.mesh({ geometries: [{ source: await readFile(process.argv[2]) }], cells: 256 });
const { offsets, starts, flags } = await mesh.columns.all();
const depth = mesh.dims[mesh.columns.axis];

/** Cells of each flag, and the longest run: a bound of the thickness along the rays. */
const found = {};
for (let ray = 0; ray + 1 < offsets.length; ray += 1) {
  for (let run = offsets[ray]; run < offsets[ray + 1]; run += 1) {
    const end = run + 1 < offsets[ray + 1] ? starts[run + 1] : depth;
    const length = end - starts[run];
    const { cells, longest } = found[flags[run]] ?? { cells: 0, longest: 0 };
    found[flags[run]] = { cells: cells + length, longest: Math.max(longest, length) };
  }
}
// 0 is the background between flags; that before the first run of a ray is not stored
delete found[0];
console.log(JSON.stringify({ dims: mesh.dims, axis: 'xyz'[mesh.columns.axis], runs: mesh.columns.runs, flags: found }));
mesher.dispose();
