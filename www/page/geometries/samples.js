/** The samples that the page offers; their models are loaded when one is taken. */
export const SAMPLES = [
  { id: 'knot', title: 'Torus knot' },
  { id: 'cubes', title: 'Two touching blocks' },
  { id: 'gear', title: 'Gear' },
  { id: 'shells', title: 'Coated core' },
  { id: 'spot', title: 'Cow' },
  { id: 'part', title: 'Machined part' },
];
