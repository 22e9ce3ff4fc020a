/* A cube from memory, meshed: how many cells lie inside. */

#include <stdio.h>
#include <stdlib.h>

#include "hexcast.h"

/* Prints an error and ends the program. */
static void fail(HexcastError *error) {
  fprintf(stderr, "error[%s]: %s\n%s\n", hexcast_error_code(error), hexcast_error_message(error), hexcast_error_hint(error));
  hexcast_error_free(error);
  exit(1);
}

/* Puts the 12 facets of a cube from 0 to 1 at `corners`. */
static void cube(float corners[12][3][3]) {
  static const unsigned char sides[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                             {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  for (int facet = 0; facet < 12; facet++)
    for (int corner = 0; corner < 3; corner++)
      for (int axis = 0; axis < 3; axis++) corners[facet][corner][axis] = (float)(sides[facet][corner] >> axis & 1);
}

int main(void) {
  HexcastError *error = NULL;
  HexcastMesher *mesher = hexcast_mesher_new("{\"backend\": \"cpu\"}", &error);
  if (!mesher) fail(error);

  float corners[12][3][3];
  cube(corners);
  const HexcastFacets facets = {.file = "cube", .corners = &corners[0][0][0], .n_facets = 12};
  const char *job = "{\"geometries\": [{\"file\": \"cube\", \"flag\": 7}], \"cells\": 10, \"padding\": {\"cells\": 2}}";
  HexcastMesh *mesh = hexcast_mesh(mesher, job, &facets, 1, &error);
  if (!mesh) fail(error);

  const uint32_t first[3] = {0, 0, 0};
  uint32_t dims[3];
  if (hexcast_mesh_dims(mesh, dims, &error)) fail(error);
  const size_t n_cells = (size_t)dims[0] * dims[1] * dims[2];
  uint8_t *flags = malloc(n_cells);
  if (!flags || hexcast_mesh_fill_box(mesh, first, dims, flags, n_cells, &error)) fail(error);

  size_t inside = 0;
  for (size_t cell = 0; cell < n_cells; cell++) inside += flags[cell] == 7;
  printf("%u x %u x %u cells, %zu inside\n", dims[0], dims[1], dims[2], inside);

  free(flags);
  hexcast_mesh_free(mesh);
  hexcast_mesher_free(mesher);
  return 0;
}
