// Serves and builds the examples: `npm run examples`.
import { fileURLToPath } from 'node:url';

const page = (folder) => fileURLToPath(new URL(`${folder}index.html`, import.meta.url));

export default {
  root: fileURLToPath(new URL('.', import.meta.url)),
  base: './',
  // models of the page
  server: { fs: { allow: ['..'] } },
  build: { rollupOptions: { input: ['', 'download/', 'progress/', 'cubes/', 'lbm/'].map(page) }, chunkSizeWarningLimit: 700 },
};
