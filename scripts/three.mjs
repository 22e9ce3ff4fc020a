// three.js for the page's 3-D view, copied so that the page loads nothing from another host.

import { cpSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { ROOT } from './run.mjs';

/** Copies three.js and its orbit controls to a folder, the bare name that the controls import made a path. */
export function copyThree(folder) {
  const three = path.join(ROOT, 'node_modules/three');
  mkdirSync(folder, { recursive: true });
  for (const file of ['three.module.js', 'three.core.js']) cpSync(path.join(three, 'build', file), path.join(folder, file));
  cpSync(path.join(three, 'LICENSE'), path.join(folder, 'LICENSE-three.txt'));
  const controls = readFileSync(path.join(three, 'examples/jsm/controls/OrbitControls.js'), 'utf8');
  const relative = controls.replace("from 'three'", "from './three.module.js'");
  if (relative === controls) throw new Error('the orbit controls of three.js do not import "three" as they did');
  writeFileSync(path.join(folder, 'OrbitControls.js'), relative);
}
