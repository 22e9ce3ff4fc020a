// The page: loads the library and shows which it is.

import init, { version } from './hexcast_wasm.js';

await init();
document.querySelector('#version').value = version();
