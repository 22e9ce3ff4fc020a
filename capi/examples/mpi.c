/* Every rank of MPI meshes its own box of one mesh, in its own memory, as a solver would; then all write it to one file.
 *
 *   mpirun -n 4 ./mpi part.stl 200 160 120 flags.raw
 *
 * part.stl is meshed with 200 x 160 x 120 cells over its bounding box. flags.raw has a byte a cell, x fastest. */

#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>

#include "hexcast.h"

/* Prints an error and ends all ranks. */
static void fail(HexcastError *error) {
  fprintf(stderr, "error[%s]: %s\n%s\n", hexcast_error_code(error), hexcast_error_message(error), hexcast_error_hint(error));
  MPI_Abort(MPI_COMM_WORLD, 1);
}

/* Writes the flags of the cells from `first` to `end`, the end exclusive, to their places in a file of `dims` cells. */
static void write_box(char *path, const uint32_t dims[3], const uint32_t first[3], const uint32_t end[3], const uint8_t *flags) {
  /* MPI counts z, y, x for what has x fastest */
  int sizes[3], subsizes[3], starts[3];
  for (int axis = 0; axis < 3; axis++) {
    sizes[2 - axis] = (int)dims[axis];
    subsizes[2 - axis] = (int)(end[axis] - first[axis]);
    starts[2 - axis] = (int)first[axis];
  }
  MPI_Datatype box;
  MPI_Type_create_subarray(3, sizes, subsizes, starts, MPI_ORDER_C, MPI_BYTE, &box);
  MPI_Type_commit(&box);
  MPI_File file;
  if (MPI_File_open(MPI_COMM_WORLD, path, MPI_MODE_CREATE | MPI_MODE_WRONLY, MPI_INFO_NULL, &file)) {
    fprintf(stderr, "%s cannot be written\n", path);
    MPI_Abort(MPI_COMM_WORLD, 1);
  }
  MPI_File_set_view(file, 0, MPI_BYTE, box, "native", MPI_INFO_NULL);
  MPI_File_write_all(file, flags, subsizes[0] * subsizes[1] * subsizes[2], MPI_BYTE, MPI_STATUS_IGNORE);
  MPI_File_close(&file);
  MPI_Type_free(&box);
}

int main(int argc, char **argv) {
  MPI_Init(&argc, &argv);
  int rank, n_ranks;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &n_ranks);
  if (argc != 6) {
    fprintf(stderr, "usage: mpi FILE.stl NX NY NZ FLAGS.raw\n");
    MPI_Abort(MPI_COMM_WORLD, 2);
  }
  uint32_t dims[3];
  for (int axis = 0; axis < 3; axis++) dims[axis] = (uint32_t)strtoul(argv[2 + axis], NULL, 10);

  /* the box of this rank in a grid of ranks over y and z */
  int grid[2] = {0, 0};
  MPI_Dims_create(n_ranks, 2, grid);
  const uint32_t place[3] = {0, (uint32_t)(rank % grid[0]), (uint32_t)(rank / grid[0])};
  const uint32_t of[3] = {1, (uint32_t)grid[0], (uint32_t)grid[1]};
  uint32_t first[3], end[3];
  for (int axis = 0; axis < 3; axis++) {
    first[axis] = (uint32_t)((uint64_t)dims[axis] * place[axis] / of[axis]);
    end[axis] = (uint32_t)((uint64_t)dims[axis] * (place[axis] + 1) / of[axis]);
  }
  char job[4096];
  snprintf(job, sizeof job, "{\"geometries\": [{\"file\": \"%s\"}], \"dims\": [%u, %u, %u], \"window\": [%u, %u, %u, %u, %u, %u]}",
           argv[1], dims[0], dims[1], dims[2], first[0], first[1], first[2], end[0], end[1], end[2]);

  HexcastError *error = NULL;
  HexcastMesher *mesher = hexcast_mesher_new("{\"backend\": \"cpu\"}", &error);
  if (!mesher) fail(error);
  HexcastMesh *mesh = hexcast_mesh(mesher, job, NULL, 0, &error);
  if (!mesh) fail(error);

  const uint32_t zero[3] = {0, 0, 0};
  uint32_t own[3];
  if (hexcast_mesh_dims(mesh, own, &error)) fail(error);
  const size_t n_cells = (size_t)own[0] * own[1] * own[2];
  uint8_t *flags = malloc(n_cells);
  if (!flags || hexcast_mesh_fill_box(mesh, zero, own, flags, n_cells, &error)) fail(error);

  unsigned long long inside = 0, all;
  for (size_t cell = 0; cell < n_cells; cell++) inside += flags[cell] != 0;
  MPI_Reduce(&inside, &all, 1, MPI_UNSIGNED_LONG_LONG, MPI_SUM, 0, MPI_COMM_WORLD);
  if (rank == 0) printf("%d ranks, %llu cells inside\n", n_ranks, all);
  write_box(argv[5], dims, first, end, flags);

  free(flags);
  hexcast_mesh_free(mesh);
  hexcast_mesher_free(mesher);
  MPI_Finalize();
  return 0;
}
