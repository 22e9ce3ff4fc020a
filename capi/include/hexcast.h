/* hexcast.h: closed surfaces in, a flag for every cell of a box out.
 *
 * Written by cbindgen from capi/src: do not edit. Link with libhexcast_c (shared or static).
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

// What went wrong. Freed by hexcast_error_free.
typedef struct HexcastError HexcastError;

// A finished mesh. Freed by hexcast_mesh_free.
typedef struct HexcastMesh HexcastMesh;

// A backend, the GPU or the CPU, that meshes one job after the other. Freed by hexcast_mesher_free.
typedef struct HexcastMesher HexcastMesher;

// An array of a mesh, and what its numbers are.
typedef struct HexcastArray {
  // Their type as NumPy names it: "|u1" uint8_t, "|i1" int8_t, "<i2" int16_t, "<i4" int32_t, "<u4" uint32_t, "<u8" uint64_t, "<f4" float,
  // "<f8" double; a text that ends with a zero byte.
  char kind[4];
  // Number of axes, 1 to 3.
  uint32_t n_axes;
  // Length of each axis, the last one fastest; 0 for those that it does not have.
  uint64_t shape[3];
  // Bytes of all numbers.
  uint64_t n_bytes;
} HexcastArray;

// Facets in memory, which a job uses in place of a file.
typedef struct HexcastFacets {
  // The name of the file in the job.
  const char *file;
  // The corners: x, y and z of the three corners of each facet, counter-clockwise seen from outside; 9 * n_facets numbers.
  const float *corners;
  // Number of facets.
  size_t n_facets;
} HexcastFacets;

// Is told how far a mesh has come: so many of `n_rays` rays are done. `user` is what the caller of hexcast_mesh_with_progress gave. Returns
// 0 to go on, any other number to cancel. It must return: neither longjmp() nor an exception may leave it.
typedef int32_t (*HexcastProgress)(uint64_t rays_done, uint64_t n_rays, void *user);

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The version of hexcast, such as "0.1.0".
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

// Puts the numbers of cells on x, y and z at `dims`: those of the window where the job has one. Returns 0, or 1 for an error.
//
// # Safety
// `mesh` is a mesh that was not freed; `dims` points to 3 numbers; `error` is NULL or a place for a pointer.
int32_t hexcast_mesh_dims(const struct HexcastMesh *mesh,
                          uint32_t *dims,
                          struct HexcastError **error);

// Puts the cells of the whole box that the mesh has at `first` and `end`, the end exclusive, and the numbers of cells of the whole
// box at `of`; 3 numbers each. Returns 0, or 1 for an error.
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
// # Safety
// `mesh` is a mesh that was not freed; `first` and `end` point to 3 numbers each; `flags` points to `n_bytes` bytes that no other
// thread uses meanwhile; `error` is NULL or a place for a pointer.
int32_t hexcast_mesh_fill_box(const struct HexcastMesh *mesh,
                              const uint32_t *first,
                              const uint32_t *end,
                              uint8_t *flags,
                              size_t n_bytes,
                              struct HexcastError **error);

// Says what an array of a mesh is. `of` is "links", "fractions" or "staggered", which the job asked for by these keys, and `name` one of the
// arrays that docs/links.md, docs/fractions.md or docs/staggered.md lists, such as "q". Returns 0, or 1 for an error.
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
// the GPU, "doubt": true for a mask of doubtful cells with each mesh (hexcast_mesh_doubt)}. With "auto" the CPU meshes where there is no GPU. Returns NULL for an error.
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
// # Safety
// As for hexcast_mesh; `progress` is NULL or a function that may be called with `user` until this function returns.
struct HexcastMesh *hexcast_mesh_with_progress(const struct HexcastMesher *mesher,
                                               const char *job,
                                               const struct HexcastFacets *facets,
                                               size_t n_facets,
                                               HexcastProgress progress,
                                               void *user,
                                               struct HexcastError **error);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* HEXCAST_H */
