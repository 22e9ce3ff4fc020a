/* The C library from outside: boxes, windows, lines, reports, errors, threads. Any failed check ends the program with 1. */

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "hexcast.h"

#define CHECK(condition)                                                     \
  do {                                                                       \
    if (!(condition)) {                                                      \
      fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition); \
      exit(1);                                                               \
    }                                                                        \
    n_checks++;                                                              \
  } while (0)

static int n_checks = 0;

/* The facets of an octahedron around the origin: the cells with |x| + |y| + |z| < 1. */
static void octahedron(float corners[8][3][3]) {
  for (int facet = 0; facet < 8; facet++) {
    float side[3];
    for (int axis = 0; axis < 3; axis++) side[axis] = (facet >> axis & 1) ? 1.0f : -1.0f;
    /* an odd number of mirrors turns the facet round */
    const int turned = side[0] * side[1] * side[2] < 0;
    for (int corner = 0; corner < 3; corner++)
      for (int axis = 0; axis < 3; axis++) {
        const int tip = turned ? 2 - corner : corner;
        corners[facet][corner][axis] = axis == tip ? side[axis] : 0.0f;
      }
  }
}

static float octahedron_corners[8][3][3];
static const HexcastFacets facets = {.file = "octahedron", .corners = &octahedron_corners[0][0][0], .n_facets = 8};

#define CORNERS(name, numbers, n) ((HexcastFacets){.file = (name), .corners = (numbers), .n_facets = (n)})
#define JOB(more) \
  "{\"geometries\": [{\"file\": \"octahedron\", \"flag\": 200}], \"dims\": [20, 16, 12], \"domain\": [-1, -1, -1, 1, 1, 1]" more "}"
enum { NX = 20, NY = 16, NZ = 12 };

/* What the flag of a cell must be; 2 where its centre lies so near the surface that this program does not know. */
static int expected(int x, int y, int z) {
  const double centre[3] = {2.0 * (x + 0.5) / NX - 1, 2.0 * (y + 0.5) / NY - 1, 2.0 * (z + 0.5) / NZ - 1};
  double sum = -1;
  for (int axis = 0; axis < 3; axis++) sum += centre[axis] < 0 ? -centre[axis] : centre[axis];
  if (sum > -1e-3 && sum < 1e-3) return 2;
  return sum < 0 ? 200 : 0;
}

/* Holds an error to its code and a part of its message, and frees it. */
static void check_error(HexcastError *error, const char *code, const char *part) {
  CHECK(error != NULL);
  if (strcmp(hexcast_error_code(error), code) || !strstr(hexcast_error_message(error), part)) {
    fprintf(stderr, "%s: %s\nin place of %s: %s\n", hexcast_error_code(error), hexcast_error_message(error), code, part);
    exit(1);
  }
  CHECK(hexcast_error_hint(error) != NULL);
  hexcast_error_free(error);
}

static HexcastMesher *mesher_of_cpu(void) {
  HexcastError *error = NULL;
  HexcastMesher *mesher = hexcast_mesher_new("{\"backend\": \"cpu\"}", &error);
  CHECK(mesher != NULL && error == NULL);
  return mesher;
}

static HexcastMesh *meshed(const HexcastMesher *mesher, const char *job) {
  HexcastError *error = NULL;
  HexcastMesh *mesh = hexcast_mesh(mesher, job, &facets, 1, &error);
  if (!mesh) fprintf(stderr, "%s\n", hexcast_error_message(error));
  CHECK(mesh != NULL && error == NULL);
  return mesh;
}

static void whole_and_windows(const HexcastMesher *mesher) {
  HexcastMesh *whole = meshed(mesher, JOB(""));
  uint32_t dims[3], first[3] = {0, 0, 0}, end[3], of[3];
  CHECK(hexcast_mesh_dims(whole, dims, NULL) == 0);
  CHECK(dims[0] == NX && dims[1] == NY && dims[2] == NZ);
  static uint8_t flags[NZ][NY][NX];
  memset(flags, 9, sizeof flags);
  CHECK(hexcast_mesh_fill_box(whole, first, dims, &flags[0][0][0], sizeof flags, NULL) == 0);
  int n_unknown = 0;
  for (int z = 0; z < NZ; z++)
    for (int y = 0; y < NY; y++)
      for (int x = 0; x < NX; x++) {
        const int flag = expected(x, y, z);
        n_unknown += flag == 2;
        CHECK(flag == 2 ? flags[z][y][x] == 0 || flags[z][y][x] == 200 : flags[z][y][x] == flag);
      }
  CHECK(n_unknown < NX * NY * NZ / 10);

  /* a window has the flags of the whole */
  HexcastMesh *window = meshed(mesher, JOB(", \"window\": [3, 2, 1, 11, 14, 8]"));
  CHECK(hexcast_mesh_window(window, first, end, of, NULL) == 0);
  CHECK(first[0] == 3 && first[1] == 2 && first[2] == 1 && end[0] == 11 && end[1] == 14 && end[2] == 8);
  CHECK(of[0] == NX && of[1] == NY && of[2] == NZ);
  static uint8_t some[7][12][8];
  const uint32_t zero[3] = {0, 0, 0}, own[3] = {8, 12, 7};
  CHECK(hexcast_mesh_fill_box(window, zero, own, &some[0][0][0], sizeof some, NULL) == 0);
  for (int z = 0; z < 7; z++)
    for (int y = 0; y < 12; y++) CHECK(memcmp(some[z][y], &flags[z + 1][y + 2][3], 8) == 0);

  /* beyond the box a halo is background, or has the flag of the nearest cell: here the corner of an inverted body */
  for (int clamps = 0; clamps < 2; clamps++) {
    char job[512];
    snprintf(job, sizeof job,
             "{\"geometries\": [{\"file\": \"octahedron\", \"flag\": 200, \"invert\": true}], \"dims\": [20, 16, 12], "
             "\"window\": [0, 0, 0, 4, 4, 4], \"halo\": 1, \"halo_edge\": \"%s\"}",
             clamps ? "clamp" : "background");
    HexcastMesh *halo = meshed(mesher, job);
    uint8_t corner[8];
    const uint32_t two[3] = {2, 2, 2};
    CHECK(hexcast_mesh_dims(halo, dims, NULL) == 0 && dims[0] == 6 && dims[1] == 6 && dims[2] == 6);
    CHECK(hexcast_mesh_fill_box(halo, zero, two, corner, sizeof corner, NULL) == 0);
    for (int cell = 0; cell < 8; cell++) CHECK(corner[cell] == (clamps || cell == 7 ? 200 : 0));
    hexcast_mesh_free(halo);
  }

  /* lines of the window are lines of the whole */
  double lines[NX + 1], own_lines[9];
  CHECK(hexcast_mesh_lines(whole, 0, lines, NX + 1, NULL) == 0);
  CHECK(hexcast_mesh_lines(window, 0, own_lines, 9, NULL) == 0);
  CHECK(lines[0] == -1.0 && lines[NX] == 1.0 && own_lines[0] == lines[3] && own_lines[8] == lines[11]);
  CHECK(strstr(hexcast_mesh_report(whole), "\"flags_hash\"") != NULL);

  /* parts are windows that a process need not choose */
  uint64_t n_cells = 0;
  for (int index = 1; index <= 3; index++) {
    char job[512];
    snprintf(job, sizeof job, JOB(", \"part\": {\"index\": %d, \"of\": [1, 1, 3]}"), index);
    HexcastMesh *part = meshed(mesher, job);
    CHECK(hexcast_mesh_window(part, first, end, of, NULL) == 0);
    n_cells += (uint64_t)(end[0] - first[0]) * (end[1] - first[1]) * (end[2] - first[2]);
    hexcast_mesh_free(part);
  }
  CHECK(n_cells == NX * NY * NZ);
  hexcast_mesh_free(whole);
  hexcast_mesh_free(window);
}

/* Counts the cells of each flag by the runs of columns, in pieces of at most so many columns, and puts each run into `flags`. */
static void walk(const HexcastMesh *mesh, size_t n_at_once, uint64_t counts[256], uint8_t *flags, const uint32_t dims[3]) {
  HexcastColumns columns;
  CHECK(hexcast_mesh_columns(mesh, &columns, NULL) == 0);
  CHECK(columns.depth == dims[columns.axis] && columns.n_columns == (uint64_t)columns.counts[0] * columns.counts[1]);
  for (int k = 0; k < 2; k++) CHECK(columns.counts[k] == dims[columns.across[k]]);
  uint64_t *ends = malloc(n_at_once * sizeof *ends), n_runs = 0;
  CHECK(ends != NULL);
  const size_t steps[3] = {1, dims[0], (size_t)dims[0] * dims[1]};
  for (uint64_t column = 0; column < columns.n_columns;) {
    const uint32_t *runs;
    size_t n_given;
    CHECK(hexcast_mesh_runs(mesh, column, n_at_once, ends, &runs, &n_given, NULL) == 0);
    CHECK(n_given >= 1 && n_given <= n_at_once && column + n_given <= columns.n_columns);
    uint64_t start = 0;
    for (size_t k = 0; k < n_given; k++, column++) {
      uint8_t *line = flags + column % columns.counts[0] * steps[columns.across[0]] + column / columns.counts[0] * steps[columns.across[1]];
      uint32_t first = 0;
      uint8_t own = 0;
      for (uint64_t run = start; run <= ends[k]; run++) {
        const uint32_t end = run < ends[k] ? HEXCAST_RUN_FIRST(runs[run]) : columns.depth;
        counts[own] += end - first;
        for (uint32_t cell = first; cell < end; cell++) line[cell * steps[columns.axis]] = own;
        if (run == ends[k]) break;
        first = end;
        own = (uint8_t)HEXCAST_RUN_FLAG(runs[run]);
      }
      start = ends[k];
    }
    n_runs += start;
  }
  CHECK(n_runs == columns.n_runs);
  free(ends);
}

/* Runs give the flags that a box has, along every axis, and however many columns are asked for at once. */
static void runs(const HexcastMesher *mesher) {
  static uint8_t flags[NX * NY * NZ], of_runs[NX * NY * NZ];
  const uint32_t zero[3] = {0, 0, 0}, dims[3] = {NX, NY, NZ};
  for (int axis = 0; axis < 3; axis++)
    for (size_t n_at_once = 1; n_at_once <= 1000; n_at_once = 10 * n_at_once + 1) {
      char job[512];
      snprintf(job, sizeof job, JOB(", \"axis\": \"%c\""), "xyz"[axis]);
      HexcastMesh *mesh = meshed(mesher, job);
      CHECK(hexcast_mesh_fill_box(mesh, zero, dims, flags, sizeof flags, NULL) == 0);
      uint64_t counts[256] = {0}, expected[256] = {0};
      for (size_t i = 0; i < sizeof flags; i++) expected[flags[i]]++;
      memset(of_runs, 9, sizeof of_runs);
      walk(mesh, n_at_once, counts, of_runs, dims);
      CHECK(memcmp(counts, expected, sizeof counts) == 0 && counts[200] > 0 && counts[0] > 0);
      CHECK(memcmp(flags, of_runs, sizeof flags) == 0);
      hexcast_mesh_free(mesh);
    }
  /* a window has columns of its own */
  HexcastMesh *window = meshed(mesher, JOB(", \"window\": [3, 2, 1, 11, 14, 8]"));
  const uint32_t own[3] = {8, 12, 7};
  uint64_t counts[256] = {0};
  CHECK(hexcast_mesh_fill_box(window, zero, own, flags, 8 * 12 * 7, NULL) == 0);
  walk(window, 50, counts, of_runs, own);
  CHECK(memcmp(flags, of_runs, 8 * 12 * 7) == 0 && counts[0] + counts[200] == 8 * 12 * 7);

  HexcastError *error = NULL;
  uint64_t end;
  const uint32_t *some;
  size_t n_given;
  CHECK(hexcast_mesh_runs(window, 672, 1, &end, &some, &n_given, &error) == 1);
  check_error(error, "job-value", "no column 672: the mesh has");
  CHECK(hexcast_mesh_runs(window, 0, 0, &end, &some, &n_given, &error) == 1);
  check_error(error, "job-value", "n_columns is 0");
  CHECK(hexcast_mesh_runs(window, 0, 1, NULL, &some, &n_given, &error) == 1);
  check_error(error, "job-value", "ends is NULL");
  CHECK(hexcast_mesh_columns(window, NULL, &error) == 1);
  check_error(error, "job-value", "columns is NULL");
  hexcast_mesh_free(window);
}

/* The octahedron by its six vertices has the cells that its corners have. */
static void vertices(const HexcastMesher *mesher) {
  static const double places[6][3] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
  uint32_t triangles[8][3];
  uint64_t triangles64[8][3];
  for (int facet = 0; facet < 8; facet++)
    for (int corner = 0; corner < 3; corner++)
      for (uint32_t place = 0; place < 6; place++) {
        int is_same = 1;
        for (int axis = 0; axis < 3; axis++) is_same &= octahedron_corners[facet][corner][axis] == (float)places[place][axis];
        if (is_same) triangles64[facet][corner] = triangles[facet][corner] = place;
      }
  HexcastFacets of_32 = {.file = "octahedron", .n_facets = 8, .vertices = &places[0][0], .n_vertices = 6, .triangles = &triangles[0][0]};
  HexcastFacets of_64 = of_32;
  of_64.triangles = NULL;
  of_64.triangles64 = &triangles64[0][0];
  static uint8_t expected_flags[NX * NY * NZ], flags[NX * NY * NZ];
  const uint32_t first[3] = {0, 0, 0}, end[3] = {NX, NY, NZ};
  HexcastMesh *mesh = meshed(mesher, JOB(""));
  CHECK(hexcast_mesh_fill_box(mesh, first, end, expected_flags, sizeof flags, NULL) == 0);
  hexcast_mesh_free(mesh);
  HexcastError *error = NULL;
  const HexcastFacets *both[] = {&of_32, &of_64};
  for (int i = 0; i < 2; i++) {
    mesh = hexcast_mesh(mesher, JOB(""), both[i], 1, &error);
    CHECK(mesh != NULL && hexcast_mesh_fill_box(mesh, first, end, flags, sizeof flags, NULL) == 0);
    CHECK(memcmp(flags, expected_flags, sizeof flags) == 0);
    hexcast_mesh_free(mesh);
  }

  HexcastFacets wrong[7] = {of_32, of_32, of_32, of_32, of_64, of_64, of_32};
  const double huge[6][3] = {{1e39, 0, 0}}, unknown[6][3] = {{strtod("nan", NULL), 0, 0}};
  wrong[0].triangles64 = of_64.triangles64;
  wrong[1].corners = &octahedron_corners[0][0][0];
  wrong[2].triangles = NULL;
  wrong[3].n_vertices = 5;
  triangles64[0][0] = UINT64_MAX;
  wrong[5].vertices = NULL;
  wrong[5].n_vertices = 6;
  static const char *parts[5] = {"vertices and triangles and triangles64", "corners and vertices and triangles", "have vertices",
                                 "vertex 5 of 5", "of 6"};
  for (int i = 0; i < 5; i++) {
    error = NULL;
    CHECK(hexcast_mesh(mesher, JOB(""), &wrong[i], 1, &error) == NULL);
    check_error(error, i < 3 ? "job-conflict" : "job-value", parts[i]);
  }
  CHECK(hexcast_mesh(mesher, JOB(""), &wrong[5], 1, &error) == NULL);
  check_error(error, "job-value", "the vertices of facets is NULL");
  wrong[6].vertices = &huge[0][0];
  CHECK(hexcast_mesh(mesher, JOB(""), &wrong[6], 1, &error) == NULL);
  check_error(error, "stl-not-finite", "vertex 0 is [1e39");
  wrong[6].vertices = &unknown[0][0];
  CHECK(hexcast_mesh(mesher, JOB(""), &wrong[6], 1, &error) == NULL);
  check_error(error, "stl-not-finite", "NaN");
}

/* What cannot be written is an error, and leaves nothing. */
static void files(const HexcastMesher *mesher) {
  const struct {
    const char *path, *options, *code, *part;
  } calls[] = {
      {NULL, NULL, "job-value", "the path is NULL"},
      {"mesh", NULL, "output-name", "no extension"},
      {"mesh.dae", NULL, "output-name", "\"dae\""},
      {"mesh.vti", "{", "job-value", "the options of the file"},
      {"mesh.vti", "{\"level\": 6}", "job-value", "level"},
      {"mesh.vti", "{\"compress\": 12}", "job-value", "compression level 12 is not 1 to 9"},
      {"mesh.vti", "{\"bits\": true}", "job-conflict", "\"bits\" does not apply"},
      {"mesh.raw", "{\"compress\": 1}", "job-conflict", "\"compress\" does not apply"},
      {"mesh.raw", "{\"ascii\": true}", "job-conflict", "\"ascii\" does not apply"},
      {"mesh.msh", "{\"map\": {\"1\": 2}}", "job-conflict", "\"map\" does not apply"},
      {"mesh.msh", "{\"open_patches\": [\"inlet\"]}", "job-conflict", "\"patches\" is missing"},
      {"mesh.msh", "{\"patches\": \"solid\"}", "job-conflict", "which this mesh does not know"},
      {"mesh.foam", NULL, "export-unit", "mesh.foam"},
      {"mesh.binvox", NULL, "lines-graded", "cubes"},
      {"no/such/folder/mesh.vti", NULL, "io", "there is no folder no/such/folder"},
      {"/", NULL, "output-name", "no extension"},
  };
  HexcastMesh *mesh = meshed(mesher, JOB(""));
  CHECK(strcmp(hexcast_mesh_lacks(mesh), "[]") == 0 && hexcast_mesh_lacks(NULL) == NULL);
  for (size_t i = 0; i < sizeof calls / sizeof calls[0]; i++) {
    HexcastError *error = NULL;
    CHECK(hexcast_mesh_write(mesh, calls[i].path, calls[i].options, &error) == 1);
    check_error(error, calls[i].code, calls[i].part);
    CHECK(!calls[i].path || calls[i].path[0] == '/' || fopen(calls[i].path, "rb") == NULL);
  }
  HexcastError *error = NULL;
  CHECK(hexcast_mesh_write(NULL, "mesh.vti", NULL, &error) == 1);
  check_error(error, "job-value", "the mesh is NULL");
  hexcast_mesh_free(mesh);
}

static void errors(const HexcastMesher *mesher) {
  HexcastError *error = NULL;
  CHECK(hexcast_mesher_new("{\"backend\": \"abacus\"}", &error) == NULL);
  check_error(error, "job-value", "abacus");
  CHECK(hexcast_mesher_new("\xff", &error) == NULL);
  check_error(error, "job-value", "not UTF-8");
  const struct {
    const char *job, *code, *part;
    const HexcastFacets *facets;
    size_t n_facets;
  } calls[] = {
      {NULL, "job-value", "the job is NULL", NULL, 0},
      {"{", "job-syntax", "not valid JSON", NULL, 0},
      {"{}", "job-empty", "no geometry", NULL, 0},
      {JOB(", \"cells\": 3"), "job-conflict", "cells", &facets, 1},
      {JOB(""), "io", "octahedron: there is no such file", NULL, 0},
      {JOB(""), "job-value", "facets is NULL", NULL, 1},
      {JOB(", \"window\": [0, 0, 0, 99, 1, 1]"), "job-value", "window", &facets, 1},
      {JOB(""), "job-value", "the corners of facets is NULL", &CORNERS("octahedron", NULL, 8), 1},
      {JOB(""), "job-value", "which no memory holds", &CORNERS("octahedron", &octahedron_corners[0][0][0], SIZE_MAX), 1},
      {JOB(""), "job-value", "the name of facets is NULL", &CORNERS(NULL, &octahedron_corners[0][0][0], 8), 1},
      {JOB(""), "job-value", "named \"cube\"", &CORNERS("cube", &octahedron_corners[0][0][0], 8), 1},
      {JOB(""), "stl-empty", "there are no facets", &CORNERS("octahedron", NULL, 0), 1},
      {JOB(""), "stl-not-finite", "NaN", &CORNERS("octahedron", ((float[9]){strtof("nan", NULL)}), 1), 1},
  };
  for (size_t i = 0; i < sizeof calls / sizeof calls[0]; i++) {
    error = NULL;
    CHECK(hexcast_mesh(mesher, calls[i].job, calls[i].facets, calls[i].n_facets, &error) == NULL);
    check_error(error, calls[i].code, calls[i].part);
    /* without a place for it an error is dropped */
    CHECK(hexcast_mesh(mesher, calls[i].job, calls[i].facets, calls[i].n_facets, NULL) == NULL);
  }
  CHECK(hexcast_mesh(NULL, JOB(""), &facets, 1, &error) == NULL);
  check_error(error, "job-value", "the mesher is NULL");

  HexcastMesh *mesh = meshed(mesher, JOB(""));
  const uint32_t first[3] = {0, 0, 0}, end[3] = {NX, NY, NZ}, past[3] = {NX, NY, NZ + 1};
  static uint8_t flags[NX * NY * (NZ + 1)];
  CHECK(hexcast_mesh_fill_box(mesh, first, past, flags, sizeof flags, &error) == 1);
  check_error(error, "job-value", "not inside the mesh");
  CHECK(hexcast_mesh_fill_box(mesh, end, first, flags, 0, &error) == 1);
  check_error(error, "job-value", "not inside the mesh");
  CHECK(hexcast_mesh_fill_box(mesh, first, end, flags, sizeof flags, &error) == 1);
  check_error(error, "job-value", "bytes for the flags of");
  CHECK(hexcast_mesh_fill_box(mesh, first, end, NULL, NX * NY * NZ, &error) == 1);
  check_error(error, "job-value", "flags is NULL");
  CHECK(hexcast_mesh_fill_box(mesh, NULL, end, flags, NX * NY * NZ, &error) == 1);
  check_error(error, "job-value", "first is NULL");
  double lines[NX + 1];
  CHECK(hexcast_mesh_lines(mesh, 3, lines, NX + 1, &error) == 1);
  check_error(error, "job-value", "axis 3");
  CHECK(hexcast_mesh_lines(mesh, 1, lines, NX + 1, &error) == 1);
  check_error(error, "job-value", "16 cells have 17 lines");
  CHECK(hexcast_mesh_dims(NULL, (uint32_t *)flags, &error) == 1);
  check_error(error, "job-value", "the mesh is NULL");
  CHECK(hexcast_mesh_report(NULL) == NULL && hexcast_error_code(NULL) == NULL);
  hexcast_mesh_free(mesh);
  hexcast_mesh_free(NULL);
  hexcast_mesher_free(NULL);
  hexcast_error_free(NULL);
}

/* What a mesh tells of its progress. */
struct told {
  int n_calls, stop_at;
  uint64_t last, n_rays;
  pthread_t thread;
};

static int32_t tell(uint64_t rays_done, uint64_t n_rays, void *user) {
  struct told *told = user;
  CHECK(rays_done >= told->last && rays_done <= n_rays);
  CHECK(pthread_equal(pthread_self(), told->thread));
  told->last = rays_done;
  told->n_rays = n_rays;
  return ++told->n_calls == told->stop_at;
}

static void progress(const HexcastMesher *mesher) {
  /* many rows of rays along x, which are cast in several rounds */
  const char *job = "{\"geometries\": [{\"file\": \"octahedron\"}], \"dims\": [4, 2000, 2000], \"axis\": \"x\"}";
  HexcastError *error = NULL;
  struct told told = {.stop_at = -1, .thread = pthread_self()};
  HexcastMesh *mesh = hexcast_mesh_with_progress(mesher, job, &facets, 1, tell, &told, &error);
  CHECK(mesh != NULL && error == NULL);
  CHECK(told.n_calls > 1 && told.n_rays == 2000 * 2000 && told.last == told.n_rays);
  hexcast_mesh_free(mesh);
  /* the first call ends the next mesh, and the mesher is as good as before */
  const int n_calls = told.n_calls;
  told = (struct told){.stop_at = 1, .thread = pthread_self()};
  CHECK(hexcast_mesh_with_progress(mesher, job, &facets, 1, tell, &told, &error) == NULL);
  check_error(error, "cancelled", "cancelled");
  CHECK(told.n_calls == 1 && n_calls > 1 && told.last < told.n_rays);
  hexcast_mesh_free(meshed(mesher, JOB("")));
  mesh = hexcast_mesh_with_progress(mesher, job, &facets, 1, NULL, NULL, NULL);
  CHECK(mesh != NULL);
  hexcast_mesh_free(mesh);
}

/* The bytes of an array, which must have this type, and so many numbers in rows; the caller frees them. */
static void *numbers(const HexcastMesh *mesh, const char *of, const char *name, const char *kind, size_t size, uint64_t n, uint64_t row) {
  HexcastArray array;
  CHECK(hexcast_mesh_array(mesh, of, name, &array, NULL) == 0);
  CHECK(strcmp(array.kind, kind) == 0 && array.n_axes == (row > 1 ? 2u : 1u));
  CHECK(array.shape[0] == n && array.shape[1] == (row > 1 ? row : 0) && array.shape[2] == 0);
  CHECK(array.n_bytes == size * n * row);
  void *bytes = malloc(array.n_bytes);
  CHECK(bytes && hexcast_mesh_fill_array(mesh, of, name, bytes, array.n_bytes, NULL) == 0);
  return bytes;
}

/* Links, fractions and staggered points of a box of 10.5 x 12 x 8 cells, whose numbers are known. */
static void measured(const HexcastMesher *mesher) {
  static float corners[12][3][3];
  static const float low[3] = {4, 2, 2}, high[3] = {14.5f, 14, 10};
  int n = 0;
  for (int axis = 0; axis < 3; axis++)
    for (int side = 0; side < 2; side++)
      for (int half = 0; half < 2; half++, n++) {
        /* two corners of a side, then one of the others; in this order or the other, so that normals point outwards */
        const int u = (axis + 1) % 3, v = (axis + 2) % 3, ends[3][2] = {{0, 0}, {1, half}, {!half, 1}};
        for (int corner = 0; corner < 3; corner++) {
          float *place = corners[n][side ? corner : 2 - corner];
          place[axis] = side ? high[axis] : low[axis];
          place[u] = ends[corner][0] ? high[u] : low[u];
          place[v] = ends[corner][1] ? high[v] : low[v];
        }
      }
  const HexcastFacets box = {.file = "box", .corners = &corners[0][0][0], .n_facets = 12};
  const char *job =
      "{\"geometries\": [{\"file\": \"box\", \"flag\": 5}], \"dims\": [20, 16, 12], \"domain\": [0, 0, 0, 20, 16, 12],"
      " \"links\": {\"stencil\": \"D3Q7\"}, \"fractions\": {\"rays\": 2, \"faces\": true}, \"staggered\": true,"
      " \"conformal\": {\"metal\": [5], \"stable\": 0}, \"tensors\": {}}";
  HexcastError *error = NULL;
  HexcastMesh *mesh = hexcast_mesh(mesher, job, &box, 1, &error);
  CHECK(mesh != NULL && hexcast_mesh_doubt(mesh) == NULL);

  /* 11 x 12 x 8 cells have their centres in the box: one at 14.5 itself lies inside, and half a cell is cut off it */
  enum { INX = 11, INY = 12, INZ = 8, LINKS = 2 * (INX * INY + INY * INZ + INX * INZ) };
  float *q = numbers(mesh, "links", "q", "<f4", 4, LINKS, 1);
  uint32_t *x = numbers(mesh, "links", "x", "<u4", 4, LINKS, 1);
  uint8_t *direction = numbers(mesh, "links", "direction", "|u1", 1, LINKS, 1), *flag = numbers(mesh, "links", "flag", "|u1", 1, LINKS, 1);
  int8_t *steps = numbers(mesh, "links", "directions", "|i1", 1, 7, 3);
  size_t of_end = 0;
  for (int link = 0; link < LINKS; link++) {
    const int is_end = steps[3 * direction[link]] == -1;
    CHECK(flag[link] == 5 && (is_end ? x[link] == 15 && q[link] == 1.0f : q[link] == 0.5f));
    of_end += is_end;
  }
  CHECK(of_end == INY * INZ);

  /* the cells 14 along x are half full */
  enum { CUT = 2 * INY * INZ };
  HexcastArray cells;
  CHECK(hexcast_mesh_array(mesh, "fractions", "cell", &cells, NULL) == 0 && strcmp(cells.kind, "<u8") == 0);
  const uint64_t n_listed = cells.shape[0];
  CHECK(n_listed >= CUT);
  uint64_t *cell = numbers(mesh, "fractions", "cell", "<u8", 8, n_listed, 1);
  uint8_t *of_flag = numbers(mesh, "fractions", "flag", "|u1", 1, n_listed, 1);
  float *fraction = numbers(mesh, "fractions", "fraction", "<f4", 4, n_listed, 1);
  float *faces = numbers(mesh, "fractions", "faces", "<f4", 4, n_listed, 6);
  size_t n_half = 0;
  for (uint64_t i = 0; i < n_listed; i++) {
    if (fraction[i] != 0.5f) continue;
    n_half++;
    CHECK(cell[i] % 20 == 14);
    /* below along x it is all of the box, above all of the outside, and half of the faces along the box */
    CHECK(faces[6 * i] == (of_flag[i] == 5 ? 1.0f : 0.0f) && faces[6 * i + 1] == (of_flag[i] == 5 ? 0.0f : 1.0f));
  }
  CHECK(n_half == CUT);

  /* Ex lies at centres along x, and on lines along y and z */
  HexcastArray points;
  CHECK(hexcast_mesh_array(mesh, "staggered", "Ex", &points, NULL) == 0 && points.n_axes == 3);
  CHECK(points.shape[0] == 13 && points.shape[1] == 17 && points.shape[2] == 20 && points.n_bytes == 13 * 17 * 20);
  uint8_t *ex = malloc(points.n_bytes);
  CHECK(hexcast_mesh_fill_array(mesh, "staggered", "Ex", ex, points.n_bytes, NULL) == 0);
  CHECK(ex[(5 * 17 + 5) * 20 + 5] == 5 && ex[(5 * 17 + 5) * 20 + 15] == 0);

  /* of the edges 14 along x half lies outside, but for those beside the box; those on its faces lie in metal */
  HexcastArray edges;
  CHECK(hexcast_mesh_array(mesh, "conformal", "Lx", &edges, NULL) == 0 && edges.n_axes == 3 && strcmp(edges.kind, "<f8") == 0);
  CHECK(edges.shape[0] == 13 && edges.shape[1] == 17 && edges.shape[2] == 20 && edges.n_bytes == 8 * 13 * 17 * 20);
  double *lx = malloc(edges.n_bytes);
  CHECK(hexcast_mesh_fill_array(mesh, "conformal", "Lx", lx, edges.n_bytes, NULL) == 0);
  CHECK(lx[(5 * 17 + 5) * 20 + 14] == 0.5 && lx[(10 * 17 + 2) * 20 + 14] == 0.5 && lx[(11 * 17 + 2) * 20 + 14] == 1.0);
  CHECK(lx[(5 * 17 + 5) * 20 + 13] == 0.0 && lx[(5 * 17 + 5) * 20 + 15] == 1.0);
  free(lx);

  /* six numbers a point: outside metal vacuum is all that there is */
  HexcastArray tensors;
  CHECK(hexcast_mesh_array(mesh, "tensors", "Ex", &tensors, NULL) == 0 && tensors.n_axes == 4 && strcmp(tensors.kind, "<f8") == 0);
  CHECK(tensors.shape[0] == 13 && tensors.shape[1] == 17 && tensors.shape[2] == 20 && tensors.shape[3] == 6);
  double *eps = malloc(tensors.n_bytes);
  CHECK(hexcast_mesh_fill_array(mesh, "tensors", "Ex", eps, tensors.n_bytes, NULL) == 0);
  for (size_t number = 0; number < tensors.n_bytes / 8; number++) CHECK(eps[number] == (number % 6 < 3 ? 1.0 : 0.0));
  free(eps);

  CHECK(hexcast_mesh_fill_array(mesh, "staggered", "Ex", ex, 7, &error) == 1);
  check_error(error, "job-value", "7 bytes");
  error = NULL;
  CHECK(hexcast_mesh_array(mesh, "links", "Q", &points, &error) == 1);
  check_error(error, "job-value", "no array \"Q\"");
  error = NULL;
  CHECK(hexcast_mesh_array(mesh, "walls", "q", &points, &error) == 1);
  check_error(error, "job-value", "walls");
  HexcastMesh *plain = meshed(mesher, JOB(""));
  error = NULL;
  CHECK(hexcast_mesh_array(plain, "links", "q", &points, &error) == 1);
  check_error(error, "job-conflict", "no links");
  hexcast_mesh_free(plain);
  hexcast_mesh_free(mesh);
  void *all[] = {q, x, direction, flag, steps, cell, of_flag, fraction, faces, ex};
  for (size_t i = 0; i < sizeof all / sizeof *all; i++) free(all[i]);
}

/* An octahedron without two of its facets: rays through the holes do not decide. */
static void doubtful(void) {
  HexcastMesher *mesher = hexcast_mesher_new("{\"backend\": \"cpu\", \"doubt\": true}", NULL);
  const HexcastFacets open = {.file = "octahedron", .corners = &octahedron_corners[0][0][0], .n_facets = 6};
  HexcastMesh *mesh = hexcast_mesh(mesher, JOB(""), &open, 1, NULL);
  CHECK(mesh != NULL && hexcast_mesh_doubt(NULL) == NULL);
  const HexcastMesh *doubt = hexcast_mesh_doubt(mesh);
  CHECK(doubt != NULL);
  const uint32_t first[3] = {0, 0, 0}, end[3] = {NX, NY, NZ};
  static uint8_t flags[NX * NY * NZ];
  CHECK(hexcast_mesh_fill_box(doubt, first, end, flags, sizeof flags, NULL) == 0);
  size_t n = 0;
  for (size_t i = 0; i < sizeof flags; i++) {
    CHECK(flags[i] <= 1);
    n += flags[i];
  }
  /* the report counts them, too */
  char wanted[64];
  snprintf(wanted, sizeof wanted, "\"doubtful\": {\n    \"cells\": %zu,", n);
  CHECK(n > 0 && strstr(hexcast_mesh_report(mesh), wanted) != NULL);
  hexcast_mesh_free(mesh);
  hexcast_mesher_free(mesher);
}

/* The number of cells that have a flag, by runs; without a check, for threads. */
/* The whole mesh of a job, as flags. */
static void flags_of(const HexcastMesh *mesh, uint8_t flags[NX * NY * NZ]) {
  HexcastError *error = NULL;
  const uint32_t first[3] = {0, 0, 0}, end[3] = {NX, NY, NZ};
  CHECK(hexcast_mesh_fill_box(mesh, first, end, flags, NX * NY * NZ, &error) == 0);
}

/* Moves the octahedron, and holds the flags, the changes and the mesh of before to whole meshes. */
static void scenes(const HexcastMesher *mesher) {
  static uint8_t flags[NX * NY * NZ], found[NX * NY * NZ], whole[NX * NY * NZ];
  HexcastError *error = NULL;
  HexcastScene *scene = hexcast_scene_new(mesher, JOB(""), &facets, 1, NULL, NULL, &error);
  CHECK(scene != NULL && error == NULL);
  const HexcastChangedRun *runs = NULL;
  size_t n_runs = 7;
  CHECK(hexcast_scene_changed(scene, &runs, &n_runs, &error) == 0 && n_runs == 0);
  CHECK(strcmp(hexcast_scene_told(scene), "") == 0 && strcmp(hexcast_scene_told(NULL), "") == 0);
  HexcastMesh *first = hexcast_scene_mesh(scene, &error);
  CHECK(first != NULL);
  flags_of(first, flags);
  for (int step = 1; step <= 6; step++) {
    char job[300];
    snprintf(job, sizeof job,
             "{\"geometries\": [{\"file\": \"octahedron\", \"flag\": %d, \"translate\": [%g, %g, 0]}],"
             " \"dims\": [20, 16, 12], \"domain\": [-1, -1, -1, 1, 1, 1]}",
             step < 4 ? 200 : 9, 0.11 * step, -0.07 * step);
    /* the facets are known */
    CHECK(hexcast_scene_update(scene, mesher, job, NULL, 0, NULL, NULL, &error) == 0);
    CHECK(strstr(hexcast_scene_told(scene), "\"whole\":null") != NULL);
    CHECK(hexcast_scene_changed(scene, &runs, &n_runs, &error) == 0 && n_runs > 0);
    HexcastMesh *mesh = hexcast_scene_mesh(scene, &error);
    CHECK(mesh != NULL);
    HexcastColumns columns;
    CHECK(hexcast_mesh_columns(mesh, &columns, &error) == 0);
    const size_t strides[3] = {1, NX, (size_t)NX * NY};
    for (size_t run = 0; run < n_runs; run++) {
      CHECK(runs[run].before != runs[run].after && runs[run].start < runs[run].end);
      const size_t across = runs[run].column % columns.counts[0] * strides[columns.across[0]] +
                            runs[run].column / columns.counts[0] * strides[columns.across[1]];
      for (uint32_t cell = runs[run].start; cell < runs[run].end; cell++) {
        uint8_t *flag = &flags[across + cell * strides[columns.axis]];
        CHECK(*flag == runs[run].before);
        *flag = runs[run].after;
      }
    }
    flags_of(mesh, found);
    CHECK(memcmp(flags, found, sizeof flags) == 0);
    HexcastMesh *of_job = meshed(mesher, job);
    flags_of(of_job, whole);
    CHECK(memcmp(flags, whole, sizeof flags) == 0);
    hexcast_mesh_free(of_job);
    hexcast_mesh_free(mesh);
  }
  /* a job that is wrong changes nothing */
  CHECK(hexcast_scene_update(scene, mesher, JOB(", \"padding\": -1"), NULL, 0, NULL, NULL, &error) == 1);
  check_error(error, "job-value", "padding");
  error = NULL;
  /* nor does one of other files: the facets are still known */
  CHECK(hexcast_scene_update(scene, mesher, "{\"geometries\": [{\"file\": \"other\"}], \"max_memory\": 1}",
                             &(HexcastFacets){.file = "other", .corners = &octahedron_corners[0][0][0], .n_facets = 8}, 1, NULL, NULL,
                             &error) == 1);
  check_error(error, "memory", "memory");
  error = NULL;
  CHECK(hexcast_scene_update(scene, mesher, JOB(""), NULL, 0, NULL, NULL, &error) == 0);
  /* other lines: all may have changed */
  CHECK(hexcast_scene_update(scene, mesher,
                             "{\"geometries\": [{\"file\": \"octahedron\", \"flag\": 1}], \"cells\": 8}", &facets, 1, NULL,
                             NULL, &error) == 0);
  CHECK(strstr(hexcast_scene_told(scene), "\"whole\":\"box\"") != NULL);
  CHECK(hexcast_scene_changed(scene, &runs, &n_runs, &error) == 0 && runs == NULL && n_runs == SIZE_MAX);
  hexcast_scene_free(scene);
  /* the first mesh is what it was */
  HexcastMesh *again = meshed(mesher, JOB(""));
  flags_of(first, found);
  flags_of(again, whole);
  CHECK(memcmp(found, whole, sizeof found) == 0);
  hexcast_mesh_free(again);
  hexcast_mesh_free(first);
  CHECK(hexcast_scene_new(NULL, JOB(""), NULL, 0, NULL, NULL, &error) == NULL);
  check_error(error, "job-value", "mesher is NULL");
  error = NULL;
  CHECK(hexcast_scene_mesh(NULL, &error) == NULL);
  check_error(error, "job-value", "scene is NULL");
  hexcast_scene_free(NULL);
}

static size_t cells_of_runs(const HexcastMesh *mesh) {
  HexcastColumns columns;
  uint64_t ends[7];
  const uint32_t *runs;
  size_t n_given, n = 0;
  if (hexcast_mesh_columns(mesh, &columns, NULL)) return 0;
  for (uint64_t column = 0; column < columns.n_columns; column += n_given) {
    if (hexcast_mesh_runs(mesh, column, 7, ends, &runs, &n_given, NULL)) return 0;
    for (size_t k = 0; k < n_given; k++)
      for (uint64_t run = k ? ends[k - 1] : 0; run < ends[k]; run++) {
        const uint32_t end = run + 1 < ends[k] ? HEXCAST_RUN_FIRST(runs[run + 1]) : columns.depth;
        n += HEXCAST_RUN_FLAG(runs[run]) ? end - HEXCAST_RUN_FIRST(runs[run]) : 0;
      }
  }
  return n;
}

static const HexcastMesher *shared_mesher;
static const HexcastMesh *shared_mesh;

/* Meshes with the mesher of all threads, and reads the mesh of all threads. Returns the cells inside, twice, and by runs. */
static void *of_thread(void *place) {
  const uint32_t first[3] = {0, 0, 0}, end[3] = {NX, NY, NZ};
  uint8_t *flags = malloc(NX * NY * NZ);
  size_t *counts = place;
  HexcastMesh *mesh = hexcast_mesh(shared_mesher, JOB(""), &facets, 1, NULL);
  const HexcastMesh *meshes[2] = {mesh, shared_mesh};
  for (int i = 0; i < 2; i++) {
    counts[i] = 0;
    if (!flags || hexcast_mesh_fill_box(meshes[i], first, end, flags, NX * NY * NZ, NULL)) continue;
    for (int cell = 0; cell < NX * NY * NZ; cell++) counts[i] += flags[cell] != 0;
  }
  counts[2] = cells_of_runs(shared_mesh);
  hexcast_mesh_free(mesh);
  free(flags);
  return NULL;
}

static void threads(const HexcastMesher *mesher) {
  enum { N = 4 };
  pthread_t threads[N];
  size_t counts[N][3];
  HexcastMesh *mesh = meshed(mesher, JOB(""));
  shared_mesher = mesher;
  shared_mesh = mesh;
  for (int i = 0; i < N; i++) CHECK(pthread_create(&threads[i], NULL, of_thread, counts[i]) == 0);
  for (int i = 0; i < N; i++) CHECK(pthread_join(threads[i], NULL) == 0);
  for (int i = 0; i < N; i++) CHECK(counts[i][0] > 0 && counts[i][0] == counts[0][0] && counts[i][1] == counts[0][0] && counts[i][2] == counts[0][0]);
  hexcast_mesh_free(mesh);
}

int main(void) {
  octahedron(octahedron_corners);
  HexcastMesher *mesher = mesher_of_cpu();
  whole_and_windows(mesher);
  errors(mesher);
  runs(mesher);
  vertices(mesher);
  files(mesher);
  CHECK(strcmp(hexcast_version(), HEXCAST_VERSION_STRING) == 0);
  measured(mesher);
  doubtful();
  scenes(mesher);
  threads(mesher);
  progress(mesher);
  /* a mesh outlives its mesher */
  HexcastMesh *mesh = meshed(mesher, JOB(""));
  hexcast_mesher_free(mesher);
  uint32_t dims[3];
  CHECK(hexcast_mesh_dims(mesh, dims, NULL) == 0 && dims[2] == NZ);
  hexcast_mesh_free(mesh);
  printf("hexcast %s: %d checks passed\n", hexcast_version(), n_checks);
  return 0;
}
