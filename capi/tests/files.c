/* Meshes the job of a file with the CPU and writes the mesh to files; prints the report, and to the standard error what files lack.
 *
 *   ./files JOB.json PATH OPTIONS [PATH OPTIONS]...
 *
 * OPTIONS may be empty, for the defaults. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "hexcast.h"

/* Prints an error and ends the program. */
static void fail(HexcastError *error) {
  fprintf(stderr, "error[%s]: %s\n%s\n", hexcast_error_code(error), hexcast_error_message(error), hexcast_error_hint(error));
  hexcast_error_free(error);
  exit(1);
}

/* The text of a file; the caller frees it. */
static char *read_text(const char *path) {
  FILE *file = fopen(path, "rb");
  char *text = calloc(1, 1 << 16);
  if (!file || !text || fread(text, 1, (1 << 16) - 1, file) == 0) {
    fprintf(stderr, "%s cannot be read\n", path);
    exit(2);
  }
  fclose(file);
  return text;
}

int main(int argc, char **argv) {
  if (argc < 4 || argc % 2 != 0) {
    fprintf(stderr, "usage: files JOB.json PATH OPTIONS [PATH OPTIONS]...\n");
    return 2;
  }
  HexcastError *error = NULL;
  HexcastMesher *mesher = hexcast_mesher_new("{\"backend\": \"cpu\", \"walls\": true}", &error);
  if (!mesher) fail(error);
  char *job = read_text(argv[1]);
  HexcastMesh *mesh = hexcast_mesh(mesher, job, NULL, 0, &error);
  if (!mesh) fail(error);
  for (int i = 2; i < argc; i += 2) {
    if (hexcast_mesh_write(mesh, argv[i], argv[i + 1][0] ? argv[i + 1] : NULL, &error)) fail(error);
    if (strcmp(hexcast_mesh_lacks(mesh), "[]") != 0) fprintf(stderr, "%s lacks %s\n", argv[i], hexcast_mesh_lacks(mesh));
  }
  puts(hexcast_mesh_report(mesh));
  free(job);
  hexcast_mesh_free(mesh);
  hexcast_mesher_free(mesher);
  return 0;
}
