/** Programs that take a file of hexcast, and what is typed in them next; `docs/export/` has more of each. */

/**
 * @typedef {object} Program
 * @property {string} name
 * @property {string[]} files of the list, of which the first that the mesh can be is written
 * @property {'field' | 'solid'} [materials] of which kind it takes materials; it must have those of a field
 * @property {(report: import('hexcast').Report) => import('hexcast').WriteOptions} [options] of the file, beside those of the list
 * @property {string} where the lines are typed
 * @property {(file: string, dims: readonly number[]) => string[]} next the lines
 */

const PYTHON = 'Then, in Python';
const TERMINAL = 'Then, in a terminal';

/** @type {Program[]} */
export const PROGRAMS = [
  {
    name: 'openEMS',
    files: ['csx-xml'],
    materials: 'field',
    where: PYTHON,
    next: (file) => [
      'from CSXCAD import ContinuousStructure',
      'structure = ContinuousStructure()',
      `structure.ReadFromXML("${file}")`,
    ],
  },
  {
    name: 'gprMax',
    files: ['in'],
    materials: 'field',
    where: 'Then, in the folder of your input file run.in',
    next: (file) => [`unzip ${file}`, 'echo "#include_file: mesh.in" >> run.in', 'python -m gprMax run.in'],
  },
  {
    name: 'OpenFOAM',
    files: ['foam'],
    where: 'Then, in the folder of your case',
    next: (file) => [`unzip ${file}`, 'checkMesh', 'paraview mesh.foam'],
  },
  {
    name: 'Abaqus, CalculiX',
    files: ['inp'],
    materials: 'solid',
    where: 'Then, in your input deck',
    next: (file) => [`*INCLUDE, INPUT=${file}`, '*BOUNDARY', 'XMIN, 1, 3'],
  },
  {
    name: 'OpenMC',
    files: ['geometry-xml'],
    where: 'Then, where materials.xml has a material for each flag',
    next: () => ['openmc --plot', 'openmc'],
  },
  { name: 'Gmsh', files: ['msh'], where: TERMINAL, next: (file) => [`gmsh -check ${file}`, `gmsh ${file}`] },
  {
    name: 'dolfinx',
    files: ['xdmf'],
    where: `${PYTHON}, beside the unpacked files`,
    next: () => [
      'file = dolfinx.io.XDMFFile(MPI.COMM_WORLD, "mesh.xdmf", "r")',
      'mesh = file.read_mesh(name="Grid")',
      'flags = file.read_meshtags(mesh, name="Grid")',
    ],
  },
  {
    name: 'lbmpy',
    files: ['npy'],
    options: () => ({ axisOrder: 'xyz' }),
    where: PYTHON,
    next: (file) => ['import numpy as np', `flags = np.load("${file}")`, 'domain_size = flags.shape'],
  },
  {
    name: 'Palabos',
    files: ['raw'],
    where: 'Then, in C++',
    next: (file, dims) => [
      `std::vector<unsigned char> flags(${dims.join(' * ')});`,
      `std::ifstream("${file}", std::ios::binary).read((char*) flags.data(), flags.size());`,
    ],
  },
  {
    name: 'taufactor',
    files: ['npy'],
    // pores are 1
    options: ({ flags }) => ({
      map: Object.fromEntries([[0, 1], ...flags.filter(({ flag }) => flag).map(({ flag }) => [flag, 0])]),
    }),
    where: PYTHON,
    next: (file) => [
      `solver = taufactor.PeriodicSolver(np.load("${file}"), device="cpu")`,
      'solver.solve()',
      'print(solver.D_eff)',
    ],
  },
  { name: 'ParaView', files: ['vtiz', 'vtrz'], where: TERMINAL, next: (file) => [`paraview ${file}`] },
  {
    name: 'NumPy',
    files: ['npz'],
    where: PYTHON,
    next: (file) => ['import numpy as np', `mesh = np.load("${file}")`, 'flags = mesh["flag"]'],
  },
  {
    name: '3D Slicer, ITK',
    files: ['nrrd'],
    where: `${PYTHON}, with pynrrd`,
    next: (file) => [`flags, header = nrrd.read("${file}")`],
  },
];
