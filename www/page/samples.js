/** The samples that the page offers; three.js, which makes their models, is loaded when one is taken. */
export const SAMPLES = [
  { id: 'knot', title: 'Torus knot' },
  { id: 'cubes', title: 'Two touching blocks' },
  { id: 'gear', title: 'Gear' },
  { id: 'shells', title: 'Coated core' },
];
