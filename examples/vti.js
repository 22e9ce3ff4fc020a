/** Meshes an STL file in Node and writes a .vti for ParaView: node vti.js part.stl part.vti [cells along the longest axis] */
import { createWriteStream } from 'node:fs';
import { readFile } from 'node:fs/promises';
import { basename } from 'node:path';
import { pipeline } from 'node:stream/promises';
import { createMesher } from 'hexcast';

const [input, output, cells = '128'] = process.argv.slice(2);
const mesher = await createMesher();
const mesh = await mesher.mesh({ geometries: [{ source: await readFile(input), file: basename(input) }], cells: Number(cells) });
await pipeline(mesh.stream('vti', { compress: 6 }), createWriteStream(output));
console.log(`${output}: ${mesh.dims.join(' x ')} cells, meshed on the ${mesh.report.backend}`);
mesher.dispose();
