/**
 * Colours of which no two are alike, on light and on dark: they differ by at least 21 in CIELAB, and by 11 as people without one of the
 * three cones see them (simulated after Machado, Oliveira and Fernandes, 2009).
 */
export const PALETTE = [
  ...[
    '#d98324',
    '#3a8fc9',
    '#10884c',
    '#ac5870',
    '#4c4cc4',
    '#d0d064',
    '#e83458',
    '#88ac94',
    '#882864',
    '#7cdcb8',
    '#7c5810',
    '#887c94',
  ],
  ...[
    '#f47cf4',
    '#644c94',
    '#d0a064',
    '#405828',
    '#10647c',
    '#10e894',
    '#dcc428',
    '#f4b8dc',
    '#e8707c',
    '#4cb8b8',
    '#5870d0',
    '#a01c4c',
  ],
];
