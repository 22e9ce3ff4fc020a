// The page: loads the library and shows which it is.

import init, { version } from './wasm/hexcast.js';

await init();
document.querySelector('#version').value = version();
