// The links and headings of Markdown, for the site of the documents and for the test that follows them.

/** A link or picture: what stands before its address, the address, what follows. Code is matched first, so that it is passed over. */
const LINK = /(^(`{3,})[^\n]*\n[\s\S]*?^\2`*$|^ {4}[^\n]*$|(`+)[^`][\s\S]*?\3)|(\]\()([^()\s]+)(\))/gm;

/** Addresses of a document's links and pictures, in its order. @param {string} text @returns {string[]} */
export function linksOf(text) {
  return [...text.matchAll(LINK)].flatMap((match) => match[5] ?? []);
}

/** The document with other addresses. @param {string} text @param {(link: string) => string} change */
export function withLinks(text, change) {
  return text.replace(LINK, (whole, code, _fence, _ticks, before, link, after) =>
    code === undefined ? `${before}${change(link)}${after}` : whole,
  );
}

/** Anchors of a document's headings, as GitHub and mdBook make them. @param {string} text @returns {string[]} */
export function anchorsOf(text) {
  const headings = text.replace(/^(`{3,})[\s\S]*?^\1`*$/gm, '').matchAll(/^#{1,6} +(.+?) *$/gm);
  /** @type {Map<string, number>} */
  const counts = new Map();
  return [...headings].map(([, heading]) => {
    const words = heading.replace(/\]\([^)]*\)/g, ']').toLowerCase();
    const anchor = words.replace(/[^\p{L}\p{N}\s_-]/gu, '').replace(/\s/g, '-');
    const n = counts.get(anchor) ?? 0;
    counts.set(anchor, n + 1);
    return n === 0 ? anchor : `${anchor}-${n}`;
  });
}
