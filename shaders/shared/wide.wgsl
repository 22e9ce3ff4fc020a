// Wide integers in two's complement on u32 limbs, lowest first: vec2 holds 64 bits, vec3 holds 96.
// All arithmetic is on u32, where wrap-around is defined. `docs/widths.md` says what proves that they are exact, and their widths enough.

fn is_negative(a: vec2<u32>) -> bool {
    return (a.y >> 31u) == 1u;
}

fn widen(a: i32) -> vec2<u32> {
    return vec2<u32>(bitcast<u32>(a), bitcast<u32>(a >> 31u));
}

fn add64(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = a.x + b.x;
    return vec2<u32>(low, a.y + b.y + u32(low < a.x));
}

fn sub64(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    return vec2<u32>(a.x - b.x, a.y - b.y - u32(a.x < b.x));
}

fn negate64(a: vec2<u32>) -> vec2<u32> {
    return sub64(vec2<u32>(0u, 0u), a);
}

// a >> bits, rounding down, for 1 <= bits <= 31
fn shift_right64(a: vec2<u32>, bits: u32) -> vec2<u32> {
    return vec2<u32>((a.x >> bits) | (a.y << (32u - bits)), bitcast<u32>(bitcast<i32>(a.y) >> bits));
}

// the 64-bit product of unsigned numbers
fn multiply_unsigned(a: u32, b: u32) -> vec2<u32> {
    let a0 = a & 0xffffu;
    let a1 = a >> 16u;
    let b0 = b & 0xffffu;
    let b1 = b >> 16u;
    let low = a0 * b0;
    let middle = a1 * b0 + (low >> 16u);
    let cross = a0 * b1 + (middle & 0xffffu);
    return vec2<u32>((cross << 16u) | (low & 0xffffu), a1 * b1 + (middle >> 16u) + (cross >> 16u));
}

// the 64-bit product of signed numbers
fn multiply_signed(a: i32, b: i32) -> vec2<u32> {
    let au = bitcast<u32>(a);
    let bu = bitcast<u32>(b);
    let product = multiply_unsigned(au, bu);
    return vec2<u32>(product.x, product.y - select(0u, bu, a < 0) - select(0u, au, b < 0));
}

fn add96(a: vec3<u32>, b: vec3<u32>) -> vec3<u32> {
    let x = a.x + b.x;
    let carry = u32(x < a.x);
    let y = a.y + b.y;
    let z = a.z + b.z + u32(y < a.y);
    let y_carried = y + carry;
    return vec3<u32>(x, y_carried, z + u32(y_carried < y));
}

fn widen96(a: vec2<u32>) -> vec3<u32> {
    return vec3<u32>(a, select(0u, 0xffffffffu, is_negative(a)));
}

// the product of a signed 64-bit and a signed 32-bit number, modulo 2^96
fn multiply96(a: vec2<u32>, b: i32) -> vec3<u32> {
    let bu = bitcast<u32>(b);
    let low = multiply_unsigned(a.x, bu);
    let high = multiply_unsigned(a.y, bu);
    var product = add96(vec3<u32>(low, 0u), vec3<u32>(0u, high));
    if is_negative(a) {
        product.z -= bu;
    }
    if b < 0 {
        let upper = sub64(product.yz, a);
        product = vec3<u32>(product.x, upper);
    }
    return product;
}

// |a|
fn magnitude96(a: vec3<u32>) -> vec3<u32> {
    if is_negative(a.yz) {
        return add96(~a, vec3<u32>(1u, 0u, 0u));
    }
    return a;
}

// a number, not negative, in f32
fn float96(a: vec3<u32>) -> f32 {
    return (f32(a.z) * 4294967296.0 + f32(a.y)) * 4294967296.0 + f32(a.x);
}

// a >> bits, rounding down, for 1 <= bits <= 31
fn shift_right96(a: vec3<u32>, bits: u32) -> vec3<u32> {
    return vec3<u32>((a.x >> bits) | (a.y << (32u - bits)), shift_right64(a.yz, bits));
}

// the nearest i32 within +-2^30
fn clamp_to_2_30(a: vec2<u32>) -> i32 {
    let fits = a.y == bitcast<u32>(bitcast<i32>(a.x) >> 31u);
    let value = select(select(0x40000000, -0x40000000, is_negative(a)), bitcast<i32>(a.x), fits);
    return clamp(value, -0x40000000, 0x40000000);
}

// a number, not negative, in f32
fn float64(a: vec2<u32>) -> f32 {
    return f32(a.y) * 4294967296.0 + f32(a.x);
}

struct Quotient {
    whole: u32,
    rest: vec2<u32>,
}

// A guess of a quotient in f32, the only arithmetic in f32 that reaches a result. It may be wrong by 2^-16 of itself: f32 and WGSL's
// 2.5 ULP of division under any rounding are wrong by less than 2^-19.
fn guess(value: f32, divisor: f32) -> f32 {
    return value / divisor;
}

// Quotient and remainder of a value, not negative, by a divisor under 2^57: exact for quotients below 2^19. Only the low 64 bits of the
// value are needed, and `size`, all of it in f32.
// Proof. Let Q be the quotient and rho = value / divisor < Q + 1. The first guess, rounded down, is off by less than 2^19 * 2^-16 + 1 =
// 9, so the rest is within +-10 divisors and fits 64 bits. The guess of what it lacks is wrong by less than 10 * 2^-16; rounded
// down it leaves a rest of more than -0.01 and less than 1.01 divisors, which the first of the two steps puts into 0 .. divisor. The
// second step is to spare: it corrects guesses that are another whole off.
// Where the quotient is larger, value = whole * divisor + rest still holds modulo 2^64.
fn quotient(value: vec2<u32>, size: f32, divisor: vec2<u32>) -> Quotient {
    let by = float64(divisor);
    let first = u32(min(guess(size, by), 1073741824.0));
    var rest = sub64(value, times64(divisor, first));
    // |rest| in f32: the sign is taken out first
    let lacks = is_negative(rest);
    let missing = guess(float64(select(rest, negate64(rest), vec2<bool>(lacks))), by);
    let more = i32(clamp(floor(select(missing, -missing, lacks)), -1048576.0, 1048576.0));
    rest = sub64(rest, times64_signed(divisor, more));
    let one = corrected(Quotient(first + bitcast<u32>(more), rest), divisor);
    return corrected(one, divisor);
}

// The same for quotients below 2^16, of which one guess is wrong by less than 1: rounded down it is within 1 of the quotient, one step
// puts the rest into 0 .. divisor, and the second is to spare.
fn small_quotient(value: vec2<u32>, size: f32, divisor: vec2<u32>) -> Quotient {
    let by = float64(divisor);
    let first = u32(min(guess(size, by), 1073741824.0));
    let one = corrected(Quotient(first, sub64(value, times64(divisor, first))), divisor);
    return corrected(one, divisor);
}

// One step towards 0 <= rest < divisor. Without branches: see sweep.wgsl.
fn corrected(q: Quotient, divisor: vec2<u32>) -> Quotient {
    let less = sub64(q.rest, divisor);
    let is_low = is_negative(q.rest);
    let is_high = !is_low && !is_negative(less);
    let raised = select(q.rest, add64(q.rest, divisor), vec2<bool>(is_low));
    return Quotient(q.whole + u32(is_high) - u32(is_low), select(raised, less, vec2<bool>(is_high)));
}

// a * b modulo 2^64
fn times64(a: vec2<u32>, b: u32) -> vec2<u32> {
    return multiply_unsigned(a.x, b) + vec2<u32>(0u, a.y * b);
}

fn times64_signed(a: vec2<u32>, b: i32) -> vec2<u32> {
    let product = times64(a, bitcast<u32>(abs(b)));
    return select(product, negate64(product), vec2<bool>(b < 0));
}

// Quotient and remainder of a signed value by a divisor, rounding down; the whole is modulo 2^32. Exact for quotients within
// +-2^19; beyond, value = whole * divisor + rest still holds modulo 2^64.
fn floor_quotient(value: vec3<u32>, divisor: vec2<u32>) -> Quotient {
    let size = magnitude96(value);
    var q = quotient(size.xy, float96(size), divisor);
    if is_negative(value.yz) {
        let is_whole = (q.rest.x | q.rest.y) == 0u;
        q.whole = select(~q.whole, 0u - q.whole, is_whole);
        q.rest = select(sub64(divisor, q.rest), q.rest, vec2<bool>(is_whole));
    }
    return q;
}
