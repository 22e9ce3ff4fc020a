// Lattice Boltzmann, D3Q19, BGK: the fluid is what the mesh left as background, and bounces back from all other cells. The box is periodic,
// and a constant force drives the flow along x. What is stored is how far the 19 distributions are from those of a fluid at rest, so that
// buffers of zeros are that fluid, and sums of f32 stay accurate. Distribution i of cell c is f[i * n_cells + c].

// Cells on x, y and z, from the page.
override NX: u32;
override NY: u32;
override NZ: u32;

// A byte a cell, as flagsBuffer makes it.
@group(0) @binding(0) var<storage, read> flags: array<u32>;
@group(0) @binding(1) var<storage, read> from_f: array<f32>;
@group(0) @binding(2) var<storage, read_write> to_f: array<f32>;
// Density less 1, and velocity, of each cell.
@group(0) @binding(3) var<storage, read_write> moments: array<vec4<f32>>;

// Relaxation rate, for a kinematic viscosity of 0.02 cells^2 a step, and force on a unit of mass.
const OMEGA = 1.0 / (3.0 * 0.02 + 0.5);
const FORCE = vec3<f32>(4e-6, 0.0, 0.0);

// Directions: i and i + 9 are opposite, the last is rest.
const C = array<vec3<i32>, 19>(
    vec3<i32>(1, 0, 0), vec3<i32>(0, 1, 0), vec3<i32>(0, 0, 1),
    vec3<i32>(1, 1, 0), vec3<i32>(1, -1, 0), vec3<i32>(1, 0, 1), vec3<i32>(1, 0, -1), vec3<i32>(0, 1, 1), vec3<i32>(0, 1, -1),
    vec3<i32>(-1, 0, 0), vec3<i32>(0, -1, 0), vec3<i32>(0, 0, -1),
    vec3<i32>(-1, -1, 0), vec3<i32>(-1, 1, 0), vec3<i32>(-1, 0, -1), vec3<i32>(-1, 0, 1), vec3<i32>(0, -1, -1), vec3<i32>(0, -1, 1),
    vec3<i32>(0, 0, 0),
);

fn weight(i: u32) -> f32 {
    return select(select(1.0 / 36.0, 1.0 / 18.0, i % 9u < 3u), 1.0 / 3.0, i == 18u);
}

fn opposite(i: u32) -> u32 {
    return select((i + 9u) % 18u, 18u, i == 18u);
}

fn index(cell: vec3<u32>) -> u32 {
    return cell.x + NX * (cell.y + NY * cell.z);
}

fn is_solid(cell: u32) -> bool {
    return ((flags[cell / 4u] >> (8u * (cell % 4u))) & 0xffu) != 0u;
}

// The distributions that arrive in a cell: from its neighbours, or back from a solid one.
fn arriving(cell: vec3<u32>) -> array<f32, 19> {
    let n = vec3<u32>(NX, NY, NZ);
    let n_cells = NX * NY * NZ;
    var f: array<f32, 19>;
    for (var i = 0u; i < 19u; i++) {
        let neighbour = index(vec3<u32>(vec3<i32>(cell + n) - C[i]) % n);
        if is_solid(neighbour) {
            f[i] = from_f[opposite(i) * n_cells + index(cell)];
        } else {
            f[i] = from_f[i * n_cells + neighbour];
        }
    }
    return f;
}

// A step of the fluid; nothing is written for solid cells.
@compute @workgroup_size(64)
fn step(@builtin(global_invocation_id) id: vec3<u32>) {
    let n_cells = NX * NY * NZ;
    if id.x >= n_cells || is_solid(id.x) {
        return;
    }
    var f = arriving(vec3<u32>(id.x % NX, id.x / NX % NY, id.x / (NX * NY)));
    let m = sums(f);
    let rho = 1.0 + m.x;
    // as Shan and Chen: the force moves the equilibrium, and mass is kept
    let u = m.yzw / rho + FORCE / OMEGA;
    for (var i = 0u; i < 19u; i++) {
        let cu = 3.0 * dot(vec3<f32>(C[i]), u);
        let moving = rho * (cu + 0.5 * cu * cu - 1.5 * dot(u, u));
        to_f[i * n_cells + id.x] = f[i] + OMEGA * (weight(i) * (m.x + moving) - f[i]);
    }
}

// Density and velocity of every cell, solid or not, from its distributions.
@compute @workgroup_size(64)
fn measure(@builtin(global_invocation_id) id: vec3<u32>) {
    let n_cells = NX * NY * NZ;
    if id.x >= n_cells {
        return;
    }
    var f: array<f32, 19>;
    for (var i = 0u; i < 19u; i++) {
        f[i] = from_f[i * n_cells + id.x];
    }
    let m = sums(f);
    moments[id.x] = vec4<f32>(m.x, m.yzw / (1.0 + m.x));
}

// Density less 1, and momentum.
fn sums(f: array<f32, 19>) -> vec4<f32> {
    var all = f;
    var m = vec4<f32>(0.0);
    for (var i = 0u; i < 19u; i++) {
        m += all[i] * vec4<f32>(1.0, vec3<f32>(C[i]));
    }
    return m;
}
