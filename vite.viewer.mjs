// The element `<hexcast-viewer>`: one module of its own, with the shaders in it, beside the package in dist/.

import path from 'node:path';
import { defineConfig } from 'vite';

export default defineConfig({
  root: path.join(import.meta.dirname, 'www'),
  publicDir: false,
  build: {
    outDir: path.join(import.meta.dirname, 'dist'),
    emptyOutDir: false,
    lib: { entry: 'viewer/viewer.js', formats: ['es'], fileName: () => 'viewer.js' },
    rolldownOptions: { output: { minify: true } },
  },
});
