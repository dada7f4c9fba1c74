/*
 * Builds that are not done at once: a wide BVH in slices of time, and a hierarchy in pieces that are written to a file.
 *
 *     in_steps INDEX.arb
 *
 * Both have the bytes of a build at once, with which they are compared. The slices are counted in looks at triangles, so
 * there are as many of them on every machine. Everything lies in static memory.
 */
#include "arboleda.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SIDE 24
#define TRIANGLES (2 * SIDE * SIDE)

/* An array of a struct whose size is ARB_ALIGNMENT begins anywhere; so it has one more, of which a part is left out. */
#define ROOM(name, bytes) static unsigned char name##_block[(bytes) + ARB_ALIGNMENT]

ROOM(index, 100000);
ROOM(other, 100000);
ROOM(scratch, 250000);
ROOM(memory, 150000);
static float triangles[TRIANGLES][9];

static void *aligned(unsigned char *block) {
    return block + (ARB_ALIGNMENT - (uintptr_t)block % ARB_ALIGNMENT) % ARB_ALIGNMENT;
}

/* Ends the program unless a function of the library succeeded. */
static void check(arb_status status, const arb_error *error) {
    if (status != ARB_OK) {
        fprintf(stderr, "%s\n", error->message);
        exit(EXIT_FAILURE);
    }
}

static void expect(bool is_so, const char *what) {
    if (!is_so) {
        fprintf(stderr, "%s\n", what);
        exit(EXIT_FAILURE);
    }
}

/* Hills: squares of two triangles each, in groups of 8 by 8 that are apart. */
static void make_hills(void) {
    int x, z, i;
    for (x = 0; x < SIDE; x++) {
        for (z = 0; z < SIDE; z++) {
            float *triangle = triangles[2 * (x * SIDE + z)];
            for (i = 0; i < 6; i++) {
                /* The corners of two triangles: (0, 0) (1, 0) (1, 1), and (0, 0) (1, 1) (0, 1). */
                int u = x + (i == 1 || i == 2 || i == 4), v = z + (i == 2 || i == 4 || i == 5);
                triangle[3 * i] = (float)(u + 40 * (x / 8));
                triangle[3 * i + 1] = (float)(u * u % 7 + v * v % 5);
                triangle[3 * i + 2] = (float)(v + 40 * (z / 8));
            }
        }
    }
}

/* Builds an index at once, to compare with. Returns the number of its bytes. */
static size_t build_at_once(uint32_t kind, const arb_mesh *mesh) {
    arb_error error;
    arb_index index;
    arb_description description;
    check(arb_build(&index, kind, mesh, NULL, aligned(other_block), sizeof other_block - ARB_ALIGNMENT,
                    aligned(scratch_block), sizeof scratch_block - ARB_ALIGNMENT, &error),
          &error);
    check(arb_describe(&index, &description), &error);
    return description.byte_count;
}

/* A wide BVH between the frames of a game, or the signs of life that a watchdog waits for. */
static void build_in_slices(const arb_mesh *mesh) {
    arb_error error;
    arb_index index;
    arb_sliced_build *build;
    size_t pauses = 0, byte_count = build_at_once(ARB_WIDE_BVH, mesh);
    bool is_done = false;

    check(arb_sliced_begin(&build, mesh, NULL, aligned(index_block), sizeof index_block - ARB_ALIGNMENT,
                           aligned(scratch_block), arb_sliced_scratch_bytes(TRIANGLES), &error),
          &error);
    while (!is_done) {
        check(arb_sliced_step(build, 1000, &is_done, &error), &error);
        pauses += !is_done; /* here a frame is drawn */
    }
    check(arb_sliced_finish(build, &index, &error), &error);

    expect(memcmp(aligned(index_block), aligned(other_block), byte_count) == 0, "the slices differ");
    printf("%s: %lu bytes, %lu pauses\n", arb_kind_name(ARB_WIDE_BVH), (unsigned long)byte_count,
           (unsigned long)pauses);
}

/* A hierarchy whose bytes go to a file, or to flash: at no time is there memory for all of them. */
static void build_in_pieces(const arb_mesh *mesh, const char *path) {
    static unsigned char room_block[8192 + ARB_ALIGNMENT];
    arb_error error;
    arb_piecewise_build *build;
    arb_piece piece;
    size_t piece_count = 0, memory_bytes, byte_count, read;
    FILE *file = fopen(path, "wb+");
    expect(file != NULL, "the file cannot be written");

    check(arb_piecewise_begin(&build, ARB_BVH_HIERARCHY, mesh, NULL, aligned(scratch_block),
                              arb_piecewise_scratch_bytes(TRIANGLES), &memory_bytes, &error),
          &error);
    expect(memory_bytes <= sizeof memory_block - ARB_ALIGNMENT, "there is not enough memory");
    check(arb_piecewise_join(build, aligned(memory_block), memory_bytes, &error), &error);
    for (;;) {
        check(arb_piecewise_next(build, aligned(room_block), sizeof room_block - ARB_ALIGNMENT, &piece, &error),
              &error);
        if (piece.byte_count == 0) {
            break;
        }
        /* The gaps between the parts of an index are zeros, as those of a file are. */
        expect(!fseek(file, (long)piece.offset, SEEK_SET) &&
                   fwrite(piece.bytes, 1, piece.byte_count, file) == piece.byte_count,
               "the file cannot be written");
        piece_count++;
    }

    byte_count = build_at_once(ARB_BVH_HIERARCHY, mesh);
    expect(byte_count == piece.index_bytes, "the lengths differ");
    rewind(file);
    read = fread(aligned(index_block), 1, byte_count, file);
    expect(read == byte_count && !memcmp(aligned(index_block), aligned(other_block), read), "the pieces differ");
    fclose(file);
    printf("%s: %lu bytes, %lu pieces\n", arb_kind_name(ARB_BVH_HIERARCHY), (unsigned long)byte_count,
           (unsigned long)piece_count);
}

int main(int argument_count, char **arguments) {
    arb_mesh mesh;
    expect(argument_count > 1, "usage: in_steps INDEX.arb");
    make_hills();
    memset(&mesh, 0, sizeof mesh);
    mesh.triangles = triangles[0];
    mesh.triangle_count = TRIANGLES;
    build_in_slices(&mesh);
    build_in_pieces(&mesh, arguments[1]);
    return 0;
}
