/** The worker: runs a core and answers messages. */
import { Core } from './core/core.js';
import { answerAll } from './core/answer_all.js';
import * as glue from './hexcast_wasm.js';

answerAll(new Core(glue));
