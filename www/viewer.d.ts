/**
 * The element `<hexcast-viewer src="mesh.hxc">`, which this module defines: it draws the cells of a column file. The pointer or the arrow
 * keys turn them, the wheel, `+` and `-` zoom, `0` shows all. Attributes, of which each may change at any time:
 *
 * - `src`: address of the file;
 * - `camera`: six numbers in world lengths, separated by spaces: the place that is looked at, and the way from it to the eye;
 * - `cut`: an axis and a place on it, as in `z 1.5`: what lies above goes; with `-z 1.5` what lies below;
 * - `hidden-flags`: flags that are not drawn, 1 to 255, separated by spaces.
 *
 * Events: `load` once the cells are there; `error` where the file cannot be read, which the element says in a sentence.
 */
export class HexcastViewer extends HTMLElement {
  /** Six numbers as in `camera`, where somebody moved it; null where all is shown. */
  get view(): number[] | null;
}

declare global {
  interface HTMLElementTagNameMap {
    'hexcast-viewer': HexcastViewer;
  }
}
