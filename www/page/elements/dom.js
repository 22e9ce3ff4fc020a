/** Elements of the page. */

/** The element of an id. @param {string} id */
export function byId(id) {
  return the(HTMLElement, id);
}

/**
 * The element of an id and of a class, such as `HTMLInputElement`; throws where the page has none.
 *
 * @template {HTMLElement} T
 * @param {new () => T} kind
 * @param {string} id
 */
function the(kind, id) {
  const element = document.getElementById(id);
  if (!(element instanceof kind)) throw new Error(`the page has no ${kind.name} "${id}"`);
  return element;
}

/** The input of an id. @param {string} id */
export function inputOf(id) {
  return the(HTMLInputElement, id);
}

/** Writes an input, unless somebody types in it. @param {string} id @param {string | number} value */
export function put(id, value) {
  const input = inputOf(id);
  if (input === document.activeElement) return;
  input.value = String(value);
  input.setCustomValidity('');
}

/** The button of an id. @param {string} id */
export function buttonOf(id) {
  return the(HTMLButtonElement, id);
}

/** The list of choices of an id. @param {string} id */
export function selectOf(id) {
  return the(HTMLSelectElement, id);
}

/** The canvas of an id. @param {string} id */
export function canvasOf(id) {
  return the(HTMLCanvasElement, id);
}

/**
 * Calls a listener with the input whenever an event happens to it.
 *
 * @param {string} id
 * @param {'input' | 'change'} event
 * @param {(input: HTMLInputElement) => void} listener
 */
export function onInput(id, event, listener) {
  const input = inputOf(id);
  input.addEventListener(event, () => listener(input));
}

/**
 * Makes an element. Properties are set as such where the element has them, else as attributes; `on` holds listeners.
 *
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, unknown> & { on?: Record<string, (event: any) => void> }} [properties]
 * @param {...(Node | string)} children
 */
export function make(tag, { on = {}, ...properties } = {}, ...children) {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(properties)) {
    if (value === undefined || value === null || value === false) continue;
    if (key in element && key !== 'list' && key !== 'role') Object.assign(element, { [key]: value });
    else element.setAttribute(key, String(value));
  }
  for (const [event, listener] of Object.entries(on)) element.addEventListener(event, listener);
  element.append(...children);
  return element;
}

/** A function that calls `action` when it was not called again for so many milliseconds. @param {() => void} action @param {number} milliseconds */
export function debounce(action, milliseconds) {
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;
  return () => {
    clearTimeout(timer);
    timer = setTimeout(action, milliseconds);
  };
}

/** Resolves after so many milliseconds. @param {number} milliseconds */
export function pause(milliseconds) {
  return new Promise((resolve) => setTimeout(resolve, milliseconds));
}

/** A function that runs an action, one run after another: where it was called during a run, however often, once more. @param {() => Promise<unknown>} action */
export function inTurn(action) {
  let [isRunning, isWanted] = [false, false];
  return async () => {
    isWanted = true;
    if (isRunning) return;
    isRunning = true;
    try {
      while (isWanted) {
        isWanted = false;
        await action();
      }
    } finally {
      isRunning = false;
    }
  };
}

/** A function that calls `draw` at most once a frame, however often it is called. @param {() => void} draw */
export function oncePerFrame(draw) {
  let isWaiting = false;
  return () => {
    if (isWaiting) return;
    isWaiting = true;
    requestAnimationFrame(() => {
      isWaiting = false;
      draw();
    });
  };
}
