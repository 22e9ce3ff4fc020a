/* hexcast.h: closed surfaces in, a flag for every cell of a box out.
 *
 * Written by cbindgen from capi/src: do not edit. Link with libhexcast (shared or static).
 *
 * A mesher meshes jobs, and hands out meshes. Whatever it hands out is freed by the function of its name, once; NULL may be freed.
 * Texts are UTF-8 and end with a zero byte. Jobs and reports are JSON, with the keys of the job file and of the report of the
 * command line.
 *
 * Errors: a function that can fail takes a place for an error, which may be NULL. Where it fails it returns NULL or a number other
 * than 0, and puts an error there, which the caller frees. Where it does not fail it leaves the place as it is.
 *
 * Threads: any function may be called from any thread. Calls that mesh with the same mesher wait for each other. A mesh does not
 * change: threads may read it at the same time, and it outlives its mesher. Nothing may be freed while another thread uses it.
 *
 * Processes: a mesher does not survive fork(). Make it after, in each process, as ranks of MPI do.
 */

#ifndef HEXCAST_H
#define HEXCAST_H

#include <stddef.h>
#include <stdint.h>

// The version of this header; hexcast_version() is that of the library.
#define HEXCAST_VERSION_MAJOR 0
#define HEXCAST_VERSION_MINOR 1
#define HEXCAST_VERSION_PATCH 0
#define HEXCAST_VERSION_STRING "0.1.0"

// The first cell, and the flag, of a run of hexcast_mesh_runs.
#define HEXCAST_RUN_FIRST(run) ((run) >> 8)
#define HEXCAST_RUN_FLAG(run) ((run) & 0xffu)

// What went wrong. Freed by hexcast_error_free.
typedef struct HexcastError HexcastError;

// A finished mesh. Freed by hexcast_mesh_free.
typedef struct HexcastMesh HexcastMesh;

// A backend, the GPU or the CPU, that meshes one job after the other. Freed by hexcast_mesher_free.
typedef struct HexcastMesher HexcastMesher;

// A job whose geometries move, and its mesh, of which each update makes what changed. Freed by hexcast_scene_free.
typedef struct HexcastScene HexcastScene;

// An array of a mesh, and what its numbers are.
typedef struct HexcastArray {
  // Their type as NumPy names it: "|u1" uint8_t, "|i1" int8_t, "<i2" int16_t, "<i4" int32_t, "<u4" uint32_t, "<u8" uint64_t, "<f4" float,
  // "<f8" double; a text that ends with a zero byte.
  char kind[4];
  // Number of axes, 1 to 4.
  uint32_t n_axes;
  // Length of each axis, the last one fastest; 0 for those that it does not have.
  uint64_t shape[4];
  // Bytes of all numbers.
  uint64_t n_bytes;
} HexcastArray;

// Facets in memory, which a job uses in place of a file: `corners`, or `vertices` and one of `triangles` and `triangles64`; the others
// are NULL. hexcast_mesh copies them: they may be freed or changed when it returns. Lengths are in the unit of the job. Normals point
// outwards where corners are counter-clockwise seen from outside.
typedef struct HexcastFacets {
  // The name of the file in the job.
  const char *file;
  // x, y and z of the three corners of each facet: 9 * n_facets numbers. NULL where there are vertices.
  const float *corners;
  // Number of facets.
  size_t n_facets;
  // x, y and z of each vertex: 3 * n_vertices numbers, each rounded to the nearest float, as all that hexcast meshes. Where coordinates are
  // large against the cells, as those of maps, subtract an origin before.
  const double *vertices;
  // Number of vertices.
  size_t n_vertices;
  // The three vertices of each facet, counted from 0: 3 * n_facets numbers.
  const uint32_t *triangles;
  // The same in 64 bits.
  const uint64_t *triangles64;
} HexcastFacets;

// Is told how far a mesh has come: so many of `n_rays` rays are done. `user` is what the caller of hexcast_mesh_with_progress gave. Returns
// 0 to go on, any other number to cancel. It must return: neither longjmp() nor an exception may leave it.
typedef int32_t (*HexcastProgress)(uint64_t rays_done, uint64_t n_rays, void *user);

// The columns of a mesh. Each holds the cells of a line along `axis`; column i + counts[0] * j has cell i on axis `across[0]` and cell j on axis
// `across[1]`. Cells are counted from the first of the mesh.
typedef struct HexcastColumns {
  // Axis of the columns: 0, 1 or 2 for x, y or z.
  uint32_t axis;
  // The other two axes, ascending.
  uint32_t across[2];
  // Number of columns on each of these.
  uint32_t counts[2];
  // Number of cells of a column.
  uint32_t depth;
  // Number of columns: counts[0] * counts[1].
  uint64_t n_columns;
  // Number of runs of all columns.
  uint64_t n_runs;
} HexcastColumns;

// Consecutive cells of a column whose flag changed.
typedef struct HexcastChangedRun {
  // The column, as hexcast_mesh_columns counts them.
  uint64_t column;
  // First cell.
  uint32_t start;
  // The cell after the last.
  uint32_t end;
  // The flag that they had.
  uint8_t before;
  // The flag that they have.
  uint8_t after;
} HexcastChangedRun;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The version of the library, such as "0.1.0"; HEXCAST_VERSION_STRING is that of the header. Before 1.0 both must have the same major and
// minor version. Lives as long as the program, and must not be freed.
const char *hexcast_version(void);

// The stable code of an error, such as "stl-truncated"; NULL for NULL. Lives as long as the error.
//
// # Safety
// `error` is NULL or an error that was not freed.
const char *hexcast_error_code(const struct HexcastError *error);

// A sentence that says what went wrong, with the numbers; NULL for NULL. Lives as long as the error.
//
// # Safety
// `error` is NULL or an error that was not freed.
const char *hexcast_error_message(const struct HexcastError *error);

// What to do about an error; may be empty. NULL for NULL. Lives as long as the error.
//
// # Safety
// `error` is NULL or an error that was not freed.
const char *hexcast_error_hint(const struct HexcastError *error);

// Frees an error.
//
// # Safety
// `error` is NULL or an error that was not freed.
void hexcast_error_free(struct HexcastError *error);

// Writes the mesh to a file, or to the files or the folder of a solver or of Zarr, in the format that the end of `path` names, as
// `hexcast mesh -o` does: .raw, .npy, .npz, .vti, .vtr, .hxc, .zarr.zip, .zarr; .foam or constant/polyMesh, .inp, .msh, .xdmf, .csx.xml, .in, .eb,
// geometry.xml, .nrrd, .vox, .binvox. A mesh of a window or part is written as a mesh of these cells alone, where they are in space. What has
// the name is replaced when all is written, not before; where it fails, nothing is left, and where the process is killed, a folder .hexcast-....part. A .raw gets a file .raw.json beside it.
//
// `options` is JSON, or NULL for the defaults: {"compress": level of zlib, 0 for none to 9 (6), "bits": eight cells a byte (false), "axis_order": "zyx" or "xyz",
// "map": {"flag": what is written for it}, "export_flags": [flags] (all but 0), "ascii": text in place of binary numbers (false), "patches":
// "side", "neighbour" or "solid" (for which the mesher needs the option "walls"), "open_patches": [solids]}. They are those of the command line. .foam has cut cells where
// the job has the key "cut_cells", and .eb needs it with "boundary"; what such files lack of the mesh, hexcast_mesh_lacks says.
//
// Flags are expanded in slabs of some MB, whatever the size of the mesh. Threads may write the same mesh at the same time, to
// different files. Returns 0, or 1 for an error.
//
// Errors: output-name for an unknown ending; job-value for NULL and for wrong options; job-conflict where an option does not apply to the format, and where
// a file of the mesh's own surfaces would be written over; lines-graded, export-unit, export-material and export-too-large where the format
// cannot hold this mesh; io where the system refuses.
//
// # Safety
// `mesh` is a mesh that was not freed; `path` is a text; `options` is NULL or a text; `error` is NULL or a place for a pointer.
int32_t hexcast_mesh_write(const struct HexcastMesh *mesh,
                           const char *path,
                           const char *options,
                           struct HexcastError **error);

// Puts the numbers of cells on x, y and z at `dims`: those of the window where the job has one. Returns 0, or 1 for an error.
//
// Errors: job-value for NULL.
//
// # Safety
// `mesh` is a mesh that was not freed; `dims` points to 3 numbers; `error` is NULL or a place for a pointer.
int32_t hexcast_mesh_dims(const struct HexcastMesh *mesh,
                          uint32_t *dims,
                          struct HexcastError **error);

// Puts the cells of the whole box that the mesh has at `first` and `end`, the end exclusive, and the numbers of cells of the whole
// box at `of`; 3 numbers each. Returns 0, or 1 for an error.
//
// Errors: job-value for NULL.
//
// # Safety
// `mesh` is a mesh that was not freed; `first`, `end` and `of` point to 3 numbers each that are not those of another; `error` is NULL
// or a place for a pointer.
int32_t hexcast_mesh_window(const struct HexcastMesh *mesh,
                            uint32_t *first,
                            uint32_t *end,
                            uint32_t *of,
                            struct HexcastError **error);

// Puts the mesh lines of an axis (0, 1 or 2 for x, y or z) at `lines`, in the unit of the surfaces: one more than cells. `n` is the
// length of `lines` and must be that. Returns 0, or 1 for an error.
//
// Errors: job-value for NULL, for another axis and for another length.
//
// # Safety
// `mesh` is a mesh that was not freed; `lines` points to `n` numbers; `error` is NULL or a place for a pointer.
int32_t hexcast_mesh_lines(const struct HexcastMesh *mesh,
                           uint32_t axis,
                           double *lines,
                           size_t n,
                           struct HexcastError **error);

// Puts the flags of a box of cells at `flags`, a byte a cell, x fastest: flags[x + nx * (y + ny * z)] with nx = end[0] - first[0] and
// so on. The cells are counted from the first of the mesh, of the window where the job has one; the end is exclusive. `n_bytes` is the
// length of `flags` and must be the number of cells of the box. Returns 0, or 1 for an error.
//
// Errors: job-value for NULL, for a box that is not inside the mesh, and for another length.
//
// # Safety
// `mesh` is a mesh that was not freed; `first` and `end` point to 3 numbers each; `flags` points to `n_bytes` bytes that no other
// thread uses meanwhile; `error` is NULL or a place for a pointer.
int32_t hexcast_mesh_fill_box(const struct HexcastMesh *mesh,
                              const uint32_t *first,
                              const uint32_t *end,
                              uint8_t *flags,
                              size_t n_bytes,
                              struct HexcastError **error);

// Says what an array of a mesh is. `of` is "links", "fractions", "staggered", "conformal", "distance" or "tensors", which the job asked for by these keys, and `name` one of the
// arrays that docs/links.md, docs/fractions.md, docs/staggered.md, docs/conformal.md, docs/distance.md or docs/tensors.md lists, such as "q". Returns 0, or 1 for an error.
//
// Errors: job-value for NULL and for names that there are not; job-conflict where the job did not ask for it.
//
// # Safety
// `mesh` is a mesh that was not freed; `of` and `name` are texts; `array` points to one; `error` is NULL or a place for a pointer.
int32_t hexcast_mesh_array(const struct HexcastMesh *mesh,
                           const char *of,
                           const char *name,
                           struct HexcastArray *array,
                           struct HexcastError **error);

// Puts the numbers of an array, as hexcast_mesh_array describes it, at `bytes`, little-endian. `n_bytes` is the length of `bytes` and must be
// that of the array. Returns 0, or 1 for an error.
//
// Errors: those of hexcast_mesh_array; job-value for another length.
//
// # Safety
// `mesh` is a mesh that was not freed; `of` and `name` are texts; `bytes` points to `n_bytes` bytes that no other thread uses meanwhile;
// `error` is NULL or a place for a pointer.
int32_t hexcast_mesh_fill_array(const struct HexcastMesh *mesh,
                                const char *of,
                                const char *name,
                                void *bytes,
                                size_t n_bytes,
                                struct HexcastError **error);

// The cells that the rays of open surfaces do not decide: a mesh with flag 1 there. NULL unless the mesher has the option "doubt". Lives as long as the mesh,
// and must not be freed.
//
// # Safety
// `mesh` is NULL or a mesh that was not freed.
const struct HexcastMesh *hexcast_mesh_doubt(const struct HexcastMesh *mesh);

// What the file lacks of the mesh that was written last (hexcast_mesh_write), as a JSON list of sentences: parts of cut cells that its format cannot hold. "[]" where it lacks
// nothing, and before the first file; NULL for NULL. Lives as long as the mesh.
//
// # Safety
// `mesh` is NULL or a mesh that was not freed.
const char *hexcast_mesh_lacks(const struct HexcastMesh *mesh);

// The report as JSON; NULL for NULL. Lives as long as the mesh.
//
// # Safety
// `mesh` is NULL or a mesh that was not freed.
const char *hexcast_mesh_report(const struct HexcastMesh *mesh);

// Frees a mesh.
//
// # Safety
// `mesh` is NULL or a mesh that was not freed and that no thread uses.
void hexcast_mesh_free(struct HexcastMesh *mesh);

// Opens a mesher. `options` is JSON, or NULL for the defaults: {"backend": "auto", "gpu" or "cpu", "adapter": a part of the name of
// the GPU, "doubt": true for a mask of doubtful cells with each mesh (hexcast_mesh_doubt), "walls": true to remember whose facets the faces between
// flags are, for "patches": "solid" of hexcast_mesh_write}. With "auto" the CPU meshes where there is no GPU. Returns NULL for an error.
//
// Errors: job-value for wrong options; no-adapter and device-... where the GPU that was asked for is not there or cannot be used.
//
// # Safety
// `options` is NULL or a text; `error` is NULL or a place for a pointer.
struct HexcastMesher *hexcast_mesher_new(const char *options,
                                         struct HexcastError **error);

// Frees a mesher.
//
// # Safety
// `mesher` is NULL or a mesher that was not freed and that no thread uses.
void hexcast_mesher_free(struct HexcastMesher *mesher);

// Meshes a job, which is JSON with the keys of the job file. "window": [i0, j0, k0, i1, j1, k1] meshes only these cells of the box,
// the end exclusive, with the flags that the whole mesh has there; "part": {"index": 1 to n, "of": [1, 1, n]} one of n windows that
// cost about the same. "backend" is not looked at: the mesher has one. Facets are taken from `facets` where one has the name of the
// job's file, and are copied; other files are read from disk. `facets` may be NULL where `n_facets` is 0. Returns NULL for an error.
//
// Errors: job-syntax, job-value, job-conflict and job-empty, domain-empty, lines-... and too-many-... for the job; job-value and job-conflict for facets that
// are not as HexcastFacets says; io where a file cannot be read; stl-... and file-syntax where it is no surface; surface-open; memory; device-... for the
// GPU.
//
// # Safety
// `mesher` is a mesher that was not freed; `job` is a text; `facets` points to so many facets, whose `corners` and `file` are as
// they say; `error` is NULL or a place for a pointer.
struct HexcastMesh *hexcast_mesh(const struct HexcastMesher *mesher,
                                 const char *job,
                                 const struct HexcastFacets *facets,
                                 size_t n_facets,
                                 struct HexcastError **error);

// Meshes a job as hexcast_mesh does, and calls `progress` on the calling thread after every band of rays, a few times a second for a
// large mesh, with `user`. Where it returns another number than 0 the mesh is cancelled: NULL is returned, with the error
// "cancelled". `progress` may be NULL, and must not use the mesher, which is busy.
//
// Errors: those of hexcast_mesh; cancelled.
//
// # Safety
// As for hexcast_mesh; `progress` is NULL or a function that may be called with `user` until this function returns.
struct HexcastMesh *hexcast_mesh_with_progress(const struct HexcastMesher *mesher,
                                               const char *job,
                                               const struct HexcastFacets *facets,
                                               size_t n_facets,
                                               HexcastProgress progress,
                                               void *user,
                                               struct HexcastError **error);

// Puts what the columns of a mesh are at `columns`. Returns 0, or 1 for an error.
//
// Errors: job-value for NULL.
//
// # Safety
// `mesh` is a mesh that was not freed; `columns` points to one; `error` is NULL or a place for a pointer.
int32_t hexcast_mesh_columns(const struct HexcastMesh *mesh,
                             struct HexcastColumns *columns,
                             struct HexcastError **error);

// Hands out the runs of columns from `column` on, without a copy: those of at most `n_columns` (1 and more) that lie together in memory. `*n_given` is the
// number of these columns, at least 1, and `*runs` their runs, column after column: those of the first are (*runs)[0] to
// (*runs)[ends[0] - 1], those of the next (*runs)[ends[0]] to (*runs)[ends[1] - 1], and so on; a column may have none. `ends` has room for
// `n_columns` numbers, of which `*n_given` are written. To go over all columns, call it again with column + *n_given.
//
// A run is its first cell * 256 + its flag: HEXCAST_RUN_FIRST(run) and HEXCAST_RUN_FLAG(run). The runs of a column ascend. A run ends where the next one begins,
// the last one at `depth` (hexcast_mesh_columns). Cells before the first run have flag 0. Neighbouring runs differ in flag, which may be 0.
//
// The runs belong to the mesh: they are not to be changed, and are there until hexcast_mesh_free. Any number of threads may walk
// them. Returns 0, or 1 for an error.
//
// Errors: job-value for NULL, for n_columns = 0, and where the mesh has no such column.
//
// # Safety
// `mesh` is a mesh that was not freed; `ends` points to room for `n_columns` numbers that no other thread uses meanwhile; `runs` and `n_given` point
// to one each; `error` is NULL or a place for a pointer.
int32_t hexcast_mesh_runs(const struct HexcastMesh *mesh,
                          uint64_t column,
                          size_t n_columns,
                          uint64_t *ends,
                          const uint32_t **runs,
                          size_t *n_given,
                          struct HexcastError **error);

// Meshes a job whose geometries will move, as hexcast_mesh_with_progress does. Give the job a "domain": without one the box follows the
// geometries, and every edit that moves its sides is a whole mesh. Returns NULL for an error.
//
// Errors: those of hexcast_mesh_with_progress.
//
// # Safety
// As for hexcast_mesh_with_progress.
struct HexcastScene *hexcast_scene_new(const struct HexcastMesher *mesher,
                                       const char *job,
                                       const struct HexcastFacets *facets,
                                       size_t n_facets,
                                       HexcastProgress progress,
                                       void *user,
                                       struct HexcastError **error);

// Gives a scene another job, and meshes what that changes: the same cells as the whole mesh of that job. `facets` are those that are new or
// other ones: a geometry whose "file" has none of them keeps the facets that the scene has under this name, also those that were read from
// disk. Any mesher may update it. Returns 0, or 1 for an error, after which the mesh is as before.
//
// Errors: those of hexcast_mesh_with_progress.
//
// # Safety
// `scene` is a scene that was not freed; else as for hexcast_mesh_with_progress.
int32_t hexcast_scene_update(const struct HexcastScene *scene,
                             const struct HexcastMesher *mesher,
                             const char *job,
                             const struct HexcastFacets *facets,
                             size_t n_facets,
                             HexcastProgress progress,
                             void *user,
                             struct HexcastError **error);

// What the last update did, as JSON: "whole": null where some rays were enough, else why the whole was meshed ("box", "surface", "asked" or
// "memory"), "rays": how many were made again, "findings" as in a report. Lives until the next update; "" before the first, and for NULL.
//
// # Safety
// `scene` is NULL or a scene that was not freed, and that no thread updates.
const char *hexcast_scene_told(const struct HexcastScene *scene);

// Hands out the runs of cells whose flags the last update changed, in the order of columns and cells, without a copy. Where the box has other
// lines or columns all may have: `*runs` is NULL and `*n_runs` SIZE_MAX. Before the first update there are none. They live until the next
// update or hexcast_scene_free. Returns 0, or 1 for an error.
//
// Errors: job-value for NULL.
//
// # Safety
// `scene` is a scene that was not freed, and that no thread updates; `runs` and `n_runs` point to one each; `error` is NULL or a place for a pointer.
int32_t hexcast_scene_changed(const struct HexcastScene *scene,
                              const struct HexcastChangedRun **runs,
                              size_t *n_runs,
                              struct HexcastError **error);

// The mesh of the last update, a handle of its own: it stays as it is when the scene goes on, shares with it what does not change, and is
// freed by hexcast_mesh_free. Where some rays were enough for that update, its report has what the columns say. Returns NULL for an error.
//
// Errors: job-value for NULL.
//
// # Safety
// `scene` is a scene that was not freed; `error` is NULL or a place for a pointer.
struct HexcastMesh *hexcast_scene_mesh(const struct HexcastScene *scene,
                                       struct HexcastError **error);

// Frees a scene.
//
// # Safety
// `scene` is NULL or a scene that was not freed and that no thread uses.
void hexcast_scene_free(struct HexcastScene *scene);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* HEXCAST_H */
