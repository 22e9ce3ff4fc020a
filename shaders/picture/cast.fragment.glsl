#version 300 es

precision highp float;
precision highp int;

struct Frame {
    vec3 eye;
    float depth_scale;
    vec3 ahead;
    float depth_offset;
    vec3 right;
    float pixels_x;
    vec3 up;
    float pixels_y;
    vec3 low;
    uint is_graded;
    vec3 high;
    uint cut;
    uvec3 cells;
    uint row_shift;
    vec3 light_down;
    uint is_fine;
    vec3 light_up;
    float jitter_x;
    uint offsets;
    uint runs;
    uint tiles_8_;
    uint tiles_64_;
    uint lines;
    uint colours;
    float jitter_y;
};
struct Corner {
    vec4 position;
    vec2 place;
};
struct Seen {
    vec4 colour;
    uvec4 cell;
    float depth;
};
struct Hit {
    ivec3 cell;
    uint flag;
    int axis;
    float t;
    bool is_start;
};
const uint MOST_STEPS = 16384u;
const float REACH = 2.6;

layout(std140) uniform Frame_block_0Fragment { Frame _group_0_binding_0_fs; };

uniform highp usampler2D _group_0_binding_1_fs;

smooth in vec2 _vs2fs_location0;
layout(location = 0) out vec4 _fs2p_location0;
layout(location = 1) out uvec4 _fs2p_location1;

vec3 direction(vec2 place_1) {
    vec3 _e3 = _group_0_binding_0_fs.ahead;
    vec3 _e6 = _group_0_binding_0_fs.right;
    vec3 _e12 = _group_0_binding_0_fs.up;
    vec3 way_3 = ((_e3 + (_e6 * place_1.x)) + (_e12 * place_1.y));
    return mix(way_3, vec3(1e-12), lessThan(abs(way_3), vec3(1e-12)));
}

uint word(uint row, uint at) {
    uint _e6 = _group_0_binding_0_fs.row_shift;
    uint _e13 = _group_0_binding_0_fs.row_shift;
    uvec4 _e18 = texelFetch(_group_0_binding_1_fs, ivec2(uvec2((at & ((1u << _e6) - 1u)), (row + (at >> _e13)))), 0);
    return _e18.x;
}

float line(int axis, int at_1) {
    uint _e4 = _group_0_binding_0_fs.is_graded;
    if ((_e4 == 0u)) {
        return float(at_1);
    }
    uint _e12 = _group_0_binding_0_fs.cells.x;
    uint _e22 = _group_0_binding_0_fs.cells.y;
    uint before_1 = (((axis > 0) ? (_e12 + 1u) : 0u) + ((axis > 1) ? (_e22 + 1u) : 0u));
    uint _e31 = _group_0_binding_0_fs.lines;
    uint _e34 = word(_e31, (before_1 + uint(at_1)));
    return uintBitsToFloat(_e34);
}

int cell_at(int axis_1, float place_2, int first, int end) {
    int low = 0;
    int high = 0;
    uint _e6 = _group_0_binding_0_fs.is_graded;
    if ((_e6 == 0u)) {
        return min(max(int(floor(place_2)), first), (end - 1));
    }
    low = first;
    high = end;
    while(true) {
        int _e16 = high;
        int _e17 = low;
        if (((_e16 - _e17) > 1)) {
        } else {
            break;
        }
        {
            int _e21 = low;
            int _e22 = high;
            int middle = ((_e21 + _e22) / 2);
            float _e26 = line(axis_1, middle);
            if ((_e26 <= place_2)) {
                low = middle;
            } else {
                high = middle;
            }
        }
    }
    int _e28 = low;
    return _e28;
}

ivec2 tile(ivec2 column, uint shift) {
    uvec2 at_5 = uvec2((column >> uvec2(shift)));
    uint _e8 = _group_0_binding_0_fs.cells.x;
    uint across = (((_e8 + (1u << shift)) - 1u) >> shift);
    uint entry = (2u * (at_5.x + (across * at_5.y)));
    uint _e23 = _group_0_binding_0_fs.tiles_8_;
    uint _e26 = _group_0_binding_0_fs.tiles_64_;
    uint row_1 = ((shift == 6u) ? _e26 : _e23);
    uint _e30 = word(row_1, entry);
    uint _e33 = word(row_1, (entry + 1u));
    return ivec2(uvec2(_e30, _e33));
}

uint run(uint at_2) {
    uint _e3 = _group_0_binding_0_fs.runs;
    uint _e4 = word(_e3, at_2);
    return _e4;
}

uint beyond(uint first_1, uint end_1, float place_3, bool or_at) {
    uint least = 0u;
    uint most = 0u;
    bool local_3 = false;
    bool local_4 = false;
    least = first_1;
    most = end_1;
    while(true) {
        uint _e6 = least;
        uint _e7 = most;
        if ((_e6 < _e7)) {
        } else {
            break;
        }
        {
            uint _e9 = least;
            uint _e10 = most;
            uint middle_1 = ((_e9 + _e10) / 2u);
            uint _e15 = run(middle_1);
            float _e19 = line(2, int((_e15 >> 8u)));
            if (!((_e19 > place_3))) {
                if (or_at) {
                    local_4 = (_e19 == place_3);
                } else {
                    local_4 = false;
                }
                bool _e28 = local_4;
                local_3 = _e28;
            } else {
                local_3 = true;
            }
            bool _e30 = local_3;
            if (_e30) {
                most = middle_1;
            } else {
                least = (middle_1 + 1u);
            }
        }
    }
    uint _e33 = least;
    return _e33;
}

bool is_seen(uint flag) {
    bool local_5 = false;
    if ((flag != 0u)) {
        uint _e7 = _group_0_binding_0_fs.colours;
        uint _e8 = word(_e7, flag);
        local_5 = ((_e8 >> 24u) != 0u);
    } else {
        local_5 = false;
    }
    bool _e14 = local_5;
    return _e14;
}

uint end_of(uint at_3, uint end_2) {
    if (((at_3 + 1u) < end_2)) {
        uint _e7 = run((at_3 + 1u));
        return (_e7 >> 8u);
    }
    uint _e13 = _group_0_binding_0_fs.cells.z;
    return _e13;
}

Hit in_column(ivec2 column_1, float w_in, float zero, float way, vec2 span, int axis_2) {
    uint after = 0u;
    float t = 0.0;
    int w = 0;
    Hit none = Hit(ivec3(0), 0u, 0, 0.0, false);
    uint _e18 = _group_0_binding_0_fs.cells.x;
    uint k = (uint(column_1.x) + (_e18 * uint(column_1.y)));
    uint _e25 = _group_0_binding_0_fs.offsets;
    uint _e26 = word(_e25, k);
    uint _e29 = _group_0_binding_0_fs.offsets;
    uint _e32 = word(_e29, (k + 1u));
    if ((_e26 >= _e32)) {
        return none;
    }
    uint _e36 = beyond(_e26, _e32, w_in, (way < 0.0));
    after = _e36;
    t = span.x;
    while(true) {
        float _e40 = t;
        if ((_e40 <= span.y)) {
        } else {
            break;
        }
        {
            uint _e43 = after;
            if ((_e43 > _e26)) {
                uint _e45 = after;
                uint _e48 = run((_e45 - 1u));
                bool _e51 = is_seen((_e48 & 255u));
                if (_e51) {
                    int begin = int((_e48 >> 8u));
                    uint _e55 = after;
                    uint _e58 = end_of((_e55 - 1u), _e32);
                    int stop = int(_e58);
                    w = ((way > 0.0) ? begin : (stop - 1));
                    uint _e66 = after;
                    if ((_e66 == _e36)) {
                        int _e69 = cell_at(2, w_in, begin, stop);
                        w = _e69;
                    }
                    int _e70 = w;
                    uint _e74 = after;
                    float _e78 = t;
                    return Hit(ivec3(column_1, _e70), (_e48 & 255u), ((_e74 == _e36) ? axis_2 : 2), _e78, false);
                }
            }
            if ((way > 0.0)) {
                uint _e83 = after;
                if ((_e83 >= _e32)) {
                    break;
                }
                uint _e86 = after;
                uint _e87 = run(_e86);
                float _e91 = line(2, int((_e87 >> 8u)));
                t = ((_e91 - zero) / way);
                uint _e95 = after;
                after = (_e95 + 1u);
            } else {
                uint _e97 = after;
                if ((_e97 <= _e26)) {
                    break;
                }
                uint _e100 = after;
                after = (_e100 - 1u);
                uint _e103 = after;
                uint _e104 = run(_e103);
                float _e108 = line(2, int((_e104 >> 8u)));
                t = ((_e108 - zero) / way);
            }
        }
    }
    return none;
}

Hit first_seen(vec3 eye, vec3 way_1) {
    int axis_3 = 0;
    vec3 origin = vec3(0.0);
    ivec2 column_2 = ivec2(0);
    float t_1 = 0.0;
    uint shift_1 = 6u;
    uint step_ = 0u;
    bool local_6 = false;
    bool local_7 = false;
    Hit hit = Hit(ivec3(0), 0u, 0, 0.0, false);
    ivec2 next = ivec2(0);
    bool local_8 = false;
    Hit none_1 = Hit(ivec3(0), 0u, 0, 0.0, false);
    vec3 inverse_ = (vec3(1.0) / way_1);
    vec3 _e14 = _group_0_binding_0_fs.low;
    vec3 to_low = ((_e14 - eye) * inverse_);
    vec3 _e19 = _group_0_binding_0_fs.high;
    vec3 to_high = ((_e19 - eye) * inverse_);
    vec3 near = min(to_low, to_high);
    vec3 far = max(to_low, to_high);
    float start = max(max(near.x, max(near.y, near.z)), 0.0);
    float length_ = (min(far.x, min(far.y, far.z)) - start);
    if ((length_ <= 0.0)) {
        return none_1;
    }
    axis_3 = ((near.x > max(near.y, near.z)) ? 0 : ((near.y > near.z) ? 1 : 2));
    origin = (eye + (way_1 * start));
    vec3 _e56 = origin;
    vec3 _e59 = _group_0_binding_0_fs.high;
    vec3 _e62 = _group_0_binding_0_fs.low;
    origin = mix(_e56, mix(_e59, _e62, greaterThan(way_1, vec3(0.0))), greaterThanEqual(near, vec3(start)));
    uvec3 _e72 = _group_0_binding_0_fs.cells;
    ivec3 n = ivec3(_e72);
    bvec2 goes_up = greaterThan(way_1.xy, vec2(0.0));
    float _e80 = origin.x;
    int _e83 = cell_at(0, _e80, 0, n.x);
    float _e86 = origin.y;
    int _e89 = cell_at(1, _e86, 0, n.y);
    column_2 = ivec2(_e83, _e89);
    bool loop_init = true;
    while(true) {
        if (!loop_init) {
            uint _e286 = step_;
            step_ = (_e286 + 1u);
        }
        loop_init = false;
        uint _e98 = step_;
        if ((_e98 < MOST_STEPS)) {
        } else {
            break;
        }
        {
            ivec2 _e101 = column_2;
            uint _e102 = shift_1;
            uint _e105 = shift_1;
            ivec2 first_2 = ((_e101 >> uvec2(_e102)) << uvec2(_e105));
            uint _e108 = shift_1;
            ivec2 end_3 = min((first_2 + ivec2((1 << _e108))), n.xy);
            float _e120 = line(0, (goes_up.x ? end_3.x : first_2.x));
            float _e122 = origin.x;
            float out_u = ((_e120 - _e122) * inverse_.x);
            float _e131 = line(1, (goes_up.y ? end_3.y : first_2.y));
            float _e133 = origin.y;
            float out_v = ((_e131 - _e133) * inverse_.y);
            float out_ = min(min(out_u, out_v), length_);
            float _e140 = origin.z;
            float _e142 = t_1;
            float w_in_1 = (_e140 + (way_1.z * _e142));
            uint _e145 = shift_1;
            if ((_e145 > 0u)) {
                ivec2 _e148 = column_2;
                uint _e149 = shift_1;
                ivec2 _e150 = tile(_e148, _e149);
                float _e152 = origin.z;
                float w_out = (_e152 + (way_1.z * out_));
                if ((_e150.x < _e150.y)) {
                    float _e163 = line(2, _e150.x);
                    local_6 = (_e163 <= max(w_in_1, w_out));
                } else {
                    local_6 = false;
                }
                bool _e167 = local_6;
                if (_e167) {
                    float _e172 = line(2, _e150.y);
                    local_7 = (_e172 >= min(w_in_1, w_out));
                } else {
                    local_7 = false;
                }
                bool _e176 = local_7;
                if (_e176) {
                    uint _e177 = shift_1;
                    shift_1 = (_e177 - 3u);
                    continue;
                }
            } else {
                ivec2 _e180 = column_2;
                float _e182 = origin.z;
                float _e184 = t_1;
                int _e186 = axis_3;
                Hit _e187 = in_column(_e180, w_in_1, _e182, way_1.z, vec2(_e184, out_), _e186);
                hit = _e187;
                uint _e190 = hit.flag;
                if ((_e190 != 0u)) {
                    float _e195 = hit.t;
                    hit.is_start = (_e195 <= 0.0);
                    float _e199 = hit.t;
                    hit.t = (_e199 + start);
                    Hit _e201 = hit;
                    return _e201;
                }
            }
            if ((out_ >= length_)) {
                break;
            }
            float _e203 = t_1;
            t_1 = max(_e203, out_);
            ivec2 _e205 = column_2;
            next = _e205;
            if ((out_u < out_v)) {
                axis_3 = 0;
                next.x = (goes_up.x ? end_3.x : (first_2.x - 1));
                float _e219 = origin.y;
                float _e221 = t_1;
                int _e226 = cell_at(1, (_e219 + (way_1.y * _e221)), first_2.y, end_3.y);
                next.y = _e226;
            } else {
                axis_3 = 1;
                float _e231 = origin.x;
                float _e233 = t_1;
                int _e238 = cell_at(0, (_e231 + (way_1.x * _e233)), first_2.x, end_3.x);
                next.x = _e238;
                next.y = (goes_up.y ? end_3.y : (first_2.y - 1));
            }
            ivec2 _e246 = next;
            if (!(any(lessThan(_e246, ivec2(0))))) {
                ivec2 _e254 = next;
                local_8 = any(greaterThanEqual(_e254, n.xy));
            } else {
                local_8 = true;
            }
            bool _e259 = local_8;
            if (_e259) {
                break;
            }
            int _e261 = column_2.x;
            int _e263 = next.x;
            int _e266 = column_2.y;
            int _e268 = next.y;
            int crossed = ((_e261 ^ _e263) | (_e266 ^ _e268));
            shift_1 = (((crossed >> 6u) != 0) ? 6u : (((crossed >> 3u) != 0) ? 3u : 0u));
            ivec2 _e284 = next;
            column_2 = _e284;
        }
    }
    return none_1;
}

float is_open(ivec3 cell) {
    bool local_9 = false;
    if (!(any(lessThan(cell, ivec3(0))))) {
        uvec3 _e10 = _group_0_binding_0_fs.cells;
        local_9 = any(greaterThanEqual(cell, ivec3(_e10)));
    } else {
        local_9 = true;
    }
    bool _e15 = local_9;
    if (_e15) {
        return 1.0;
    }
    uint _e22 = _group_0_binding_0_fs.cells.x;
    uint k_1 = (uint(cell.x) + (_e22 * uint(cell.y)));
    uint _e29 = _group_0_binding_0_fs.offsets;
    uint _e30 = word(_e29, k_1);
    uint _e33 = _group_0_binding_0_fs.offsets;
    uint _e36 = word(_e33, (k_1 + 1u));
    if ((_e30 >= _e36)) {
        return 1.0;
    }
    float _e41 = line(2, cell.z);
    uint _e43 = beyond(_e30, _e36, _e41, false);
    if ((_e43 == _e30)) {
        return 1.0;
    }
    uint _e48 = run((_e43 - 1u));
    bool _e51 = is_seen((_e48 & 255u));
    return (_e51 ? 0.0 : 1.0);
}

float corner(float side, float other, float between) {
    return (0.58 + (0.14 * ((side + other) + (((side + other) == 0.0) ? 0.0 : between))));
}

float corner_light(Hit hit_1, vec3 within, bool up) {
    ivec3 before = ivec3(0);
    ivec3 one = ivec3(0);
    ivec3 other_1 = ivec3(0);
    int a = ((hit_1.axis + 1) % 3);
    int b = ((hit_1.axis + 2) % 3);
    before = hit_1.cell;
    int _e17 = before[hit_1.axis];
    before[hit_1.axis] = (_e17 + (up ? 1 : -1));
    one[a] = 1;
    other_1[b] = 1;
    ivec3 _e32 = before;
    ivec3 _e33 = one;
    float _e35 = is_open((_e32 - _e33));
    ivec3 _e36 = before;
    ivec3 _e37 = one;
    float _e39 = is_open((_e36 + _e37));
    ivec3 _e40 = before;
    ivec3 _e41 = other_1;
    float _e43 = is_open((_e40 - _e41));
    ivec3 _e44 = before;
    ivec3 _e45 = other_1;
    float _e47 = is_open((_e44 + _e45));
    ivec3 _e48 = before;
    ivec3 _e49 = one;
    ivec3 _e51 = other_1;
    float _e53 = is_open(((_e48 - _e49) - _e51));
    float _e54 = corner(_e35, _e43, _e53);
    ivec3 _e55 = before;
    ivec3 _e56 = one;
    ivec3 _e58 = other_1;
    float _e60 = is_open(((_e55 + _e56) - _e58));
    float _e61 = corner(_e39, _e43, _e60);
    ivec3 _e62 = before;
    ivec3 _e63 = one;
    ivec3 _e65 = other_1;
    float _e67 = is_open(((_e62 - _e63) + _e65));
    float _e68 = corner(_e35, _e47, _e67);
    ivec3 _e69 = before;
    ivec3 _e70 = one;
    ivec3 _e72 = other_1;
    float _e74 = is_open(((_e69 + _e70) + _e72));
    float _e75 = corner(_e39, _e47, _e74);
    return mix(mix(_e54, _e61, within[a]), mix(_e68, _e75, within[a]), within[b]);
}

float round_light(Hit hit_2, vec3 within_1, bool up_1) {
    vec3 place_4 = vec3(0.0);
    vec3 normal = vec3(0.0);
    float open = 0.0;
    int at_4 = 0;
    place_4 = (vec3(hit_2.cell) + within_1);
    place_4[hit_2.axis] = (float(hit_2.cell[hit_2.axis]) + (up_1 ? 1.01 : -0.01));
    bool loop_init_1 = true;
    while(true) {
        if (!loop_init_1) {
            int _e66 = at_4;
            at_4 = (_e66 + 1);
        }
        loop_init_1 = false;
        int _e24 = at_4;
        if ((_e24 < 27)) {
        } else {
            break;
        }
        {
            int _e27 = at_4;
            if ((_e27 == 13)) {
                continue;
            }
            int _e30 = at_4;
            int _e34 = at_4;
            int _e40 = at_4;
            vec3 way_4 = (vec3(float((_e30 % 3)), float(((_e34 / 3) % 3)), float((_e40 / 9))) - vec3(1.0));
            vec3 _e48 = place_4;
            float _e57 = is_open(ivec3(floor((_e48 + (way_4 * (REACH / sqrt(dot(way_4, way_4))))))));
            vec3 _e58 = normal;
            normal = (_e58 + (way_4 * (_e57 / dot(way_4, way_4))));
            float _e63 = open;
            open = (_e63 + _e57);
        }
    }
    vec3 _e68 = normal;
    vec3 _e69 = normal;
    if ((dot(_e68, _e69) == 0.0)) {
        return 0.5;
    }
    vec3 _e74 = normal;
    normal = normalize(_e74);
    vec3 _e76 = normal;
    vec3 _e82 = _group_0_binding_0_fs.light_up;
    vec3 _e84 = normal;
    vec3 _e91 = _group_0_binding_0_fs.light_down;
    vec3 light_1 = ((max(_e76, vec3(0.0)) * _e82) + (max(-(_e84), vec3(0.0)) * _e91));
    vec3 _e94 = normal;
    float tone = dot(light_1, abs(_e94));
    float _e97 = open;
    return (tone * (0.72 + (0.28 * smoothstep(0.2, 0.55, (_e97 / 26.0)))));
}

float shade(Hit hit_3, vec3 way_2, bool up_2, bool is_cut) {
    vec3 drawn = vec3(0.0);
    float light = 0.0;
    vec3 _e6 = _group_0_binding_0_fs.eye;
    vec3 place_5 = (_e6 + (way_2 * hit_3.t));
    float _e13 = line(0, hit_3.cell.x);
    float _e17 = line(1, hit_3.cell.y);
    float _e21 = line(2, hit_3.cell.z);
    vec3 low_1 = vec3(_e13, _e17, _e21);
    float _e28 = line(0, (hit_3.cell.x + 1));
    float _e34 = line(1, (hit_3.cell.y + 1));
    float _e40 = line(2, (hit_3.cell.z + 1));
    vec3 size = (vec3(_e28, _e34, _e40) - low_1);
    vec3 _e46 = _group_0_binding_0_fs.right;
    float _e51 = _group_0_binding_0_fs.right[hit_3.axis];
    float _e60 = _group_0_binding_0_fs.pixels_x;
    vec3 right = ((hit_3.t * (_e46 - (way_2 * (_e51 / way_2[hit_3.axis])))) / vec3(_e60));
    vec3 _e66 = _group_0_binding_0_fs.up;
    float _e71 = _group_0_binding_0_fs.up[hit_3.axis];
    float _e80 = _group_0_binding_0_fs.pixels_y;
    vec3 above = ((hit_3.t * (_e66 - (way_2 * (_e71 / way_2[hit_3.axis])))) / vec3(_e80));
    vec3 per_pixel = max(((abs(right) + abs(above)) / size), vec3(1e-6));
    vec3 within_2 = clamp(((place_5 - low_1) / size), vec3(0.0), vec3(1.0));
    vec3 to_line = (min(within_2, (vec3(1.0) - within_2)) / per_pixel);
    drawn = ((vec3(1.0) - smoothstep(vec3(0.3), vec3(1.1), to_line)) * (vec3(1.0) - smoothstep(vec3(0.07), vec3(0.1667), per_pixel)));
    drawn[hit_3.axis] = 0.0;
    float _e124 = drawn.x;
    float _e126 = drawn.y;
    float _e128 = drawn.z;
    float edge = max(_e124, max(_e126, _e128));
    float _e135 = _group_0_binding_0_fs.light_down[hit_3.axis];
    float _e140 = _group_0_binding_0_fs.light_up[hit_3.axis];
    light = (up_2 ? _e140 : _e135);
    if (is_cut) {
        light = 1.0;
    } else {
        uint _e146 = _group_0_binding_0_fs.is_fine;
        if ((_e146 != 0u)) {
            float large = (1.0 - smoothstep(0.1, 0.3, max(per_pixel.x, max(per_pixel.y, per_pixel.z))));
            float _e159 = light;
            float _e160 = corner_light(hit_3, within_2, up_2);
            light = (_e159 * mix(1.0, _e160, large));
            if ((large < 1.0)) {
                float _e166 = round_light(hit_3, within_2, up_2);
                float _e167 = light;
                light = mix(_e166, _e167, large);
            }
        }
    }
    float _e169 = light;
    return (_e169 * (1.0 - (0.34 * edge)));
}

void main() {
    vec2 place = _vs2fs_location0;
    bool local = false;
    bool local_1 = false;
    bool local_2 = false;
    float _e3 = _group_0_binding_0_fs.jitter_x;
    float _e6 = _group_0_binding_0_fs.pixels_x;
    float _e10 = _group_0_binding_0_fs.jitter_y;
    float _e13 = _group_0_binding_0_fs.pixels_y;
    vec2 at_6 = (place + vec2((_e3 / _e6), (_e10 / _e13)));
    vec3 _e17 = direction(at_6);
    vec3 _e20 = _group_0_binding_0_fs.eye;
    Hit _e21 = first_seen(_e20, _e17);
    if ((_e21.flag == 0u)) {
        discard;
    }
    bool up_3 = (_e17[_e21.axis] < 0.0);
    if (_e21.is_start) {
        uint _e34 = _group_0_binding_0_fs.cut;
        local = (_e34 != 6u);
    } else {
        local = false;
    }
    bool _e38 = local;
    if (_e38) {
        uint _e44 = _group_0_binding_0_fs.cut;
        local_1 = (_e21.axis == int((_e44 % 3u)));
    } else {
        local_1 = false;
    }
    bool _e50 = local_1;
    if (_e50) {
        uint _e55 = _group_0_binding_0_fs.cut;
        local_2 = (up_3 == (_e55 >= 3u));
    } else {
        local_2 = false;
    }
    bool is_cut_1 = local_2;
    uint _e63 = _group_0_binding_0_fs.colours;
    uint _e65 = word(_e63, _e21.flag);
    vec3 colour = (vec4(_e65 & 0xFFu, _e65 >> 8 & 0xFFu, _e65 >> 16 & 0xFFu, _e65 >> 24) / 255.0).xyz;
    uint face = (is_cut_1 ? 6u : (uint(_e21.axis) + (up_3 ? 3u : 0u)));
    float _e76 = shade(_e21, _e17, up_3, is_cut_1);
    float _e79 = _group_0_binding_0_fs.depth_scale;
    float _e84 = _group_0_binding_0_fs.depth_offset;
    float depth = ((_e79 / _e21.t) + _e84);
    Seen _tmp_return = Seen(vec4((colour * _e76), 1.0), uvec4(uvec3(_e21.cell), (_e21.flag | (face << 8u))), depth);
    _fs2p_location0 = _tmp_return.colour;
    _fs2p_location1 = _tmp_return.cell;
    gl_FragDepth = _tmp_return.depth;
    return;
}

