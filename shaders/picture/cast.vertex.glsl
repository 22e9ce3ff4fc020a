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

smooth out vec2 _vs2fs_location0;

float corner(float side, float other, float between) {
    return (0.58 + (0.14 * ((side + other) + (((side + other) == 0.0) ? 0.0 : between))));
}

void main() {
    uint index = uint(gl_VertexID);
    vec2 place_5 = ((vec2(float((index & 1u)), float((index >> 1u))) * 4.0) - vec2(1.0));
    Corner _tmp_return = Corner(vec4(place_5, 0.0, 1.0), place_5);
    gl_Position = _tmp_return.position;
    _vs2fs_location0 = _tmp_return.place;
    return;
}

