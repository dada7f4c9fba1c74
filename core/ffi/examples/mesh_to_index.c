/*
 * A mesh from a file, its index to a file, and a batch of rays through the index that is read again.
 *
 *     mesh_to_index MESH.obj INDEX.arb [RAYS]
 *
 * Reads `v x y z` and `f a b c` lines of an OBJ file. Prints a line with the digest of all hits, which is the same on
 * every machine and for every kind of index.
 */
#include "arboleda.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void fail(const char *what, const char *why) {
    fprintf(stderr, "%s: %s\n", what, why);
    exit(EXIT_FAILURE);
}

/* Ends the program unless a function of the library succeeded. `error` may be NULL. */
static void check(const char *what, arb_status status, const arb_error *error) {
    if (status != ARB_OK) {
        fail(what, error ? error->message : arb_status_text(status));
    }
}

/* --- Memory ------------------------------------------------------------------------------------------------------ */

static void *allocate(size_t bytes) {
    void *memory = malloc(bytes ? bytes : 1);
    if (!memory) {
        fail("memory", "there is not enough");
    }
    return memory;
}

/* Memory that starts at a multiple of ARB_ALIGNMENT bytes; `block` is what to free. */
static void *allocate_aligned(size_t bytes, void **block) {
    char *first;
    *block = allocate(bytes + ARB_ALIGNMENT - 1);
    first = *block;
    return first + (ARB_ALIGNMENT - (uintptr_t)first % ARB_ALIGNMENT) % ARB_ALIGNMENT;
}

/* --- Mesh from a file -------------------------------------------------------------------------------------------- */

/* Array of `count` elements that grows by half when it is full. */
static void *with_room(void *array, size_t count, size_t *room, size_t element) {
    if (count < *room) {
        return array;
    }
    *room += *room / 2 + 256;
    array = realloc(array, *room * element);
    if (!array) {
        fail("memory", "there is not enough");
    }
    return array;
}

static void read_mesh(const char *path, float (**vertices)[3], uint32_t (**corners)[3], arb_mesh *mesh) {
    char line[256];
    size_t vertex_room = 0, triangle_room = 0;
    FILE *file = fopen(path, "r");
    if (!file) {
        fail(path, "cannot be opened");
    }
    *vertices = NULL;
    *corners = NULL;
    memset(mesh, 0, sizeof *mesh);
    while (fgets(line, sizeof line, file)) {
        if (strncmp(line, "v ", 2) == 0) {
            float *vertex;
            *vertices = with_room(*vertices, mesh->vertex_count, &vertex_room, sizeof **vertices);
            vertex = (*vertices)[mesh->vertex_count++];
            if (sscanf(line + 2, "%f %f %f", &vertex[0], &vertex[1], &vertex[2]) != 3) {
                fail(path, "a vertex needs three numbers");
            }
        } else if (strncmp(line, "f ", 2) == 0) {
            unsigned long number[3];
            int i;
            if (sscanf(line + 2, "%lu%*[0-9/] %lu%*[0-9/] %lu", &number[0], &number[1], &number[2]) != 3 &&
                sscanf(line + 2, "%lu %lu %lu", &number[0], &number[1], &number[2]) != 3) {
                fail(path, "a face needs three vertices");
            }
            *corners = with_room(*corners, mesh->triangle_count, &triangle_room, sizeof **corners);
            for (i = 0; i < 3; i++) {
                /* OBJ counts from 1. arb_build refuses numbers of vertices that are not there. */
                (*corners)[mesh->triangle_count][i] = (uint32_t)(number[i] - 1);
            }
            mesh->triangle_count++;
        }
    }
    fclose(file);
    mesh->vertices = *vertices ? **vertices : NULL;
    mesh->corners = *corners ? **corners : NULL;
}

/* --- Index to a file, and back ----------------------------------------------------------------------------------- */

static void build_and_write(const arb_mesh *mesh, const char *path) {
    arb_options options;
    arb_capacity capacity;
    arb_description description;
    arb_error error;
    arb_index index;
    size_t scratch_bytes;
    void *scratch, *memory, *scratch_block, *memory_block;
    FILE *file;

    check("options", arb_options_default(&options, sizeof options), NULL);
    options.work_limit = 1000000000; /* a build of unknown triangles ends within some seconds */

    /* 1. The scratch: enough for so many triangles, wherever they lie. */
    check("scratch", arb_scratch_bytes(ARB_WIDE_BVH, mesh->triangle_count, &options, &scratch_bytes, &error), &error);
    scratch = allocate_aligned(scratch_bytes, &scratch_block);

    /* 2. The index: exactly as much as this mesh needs. */
    check("measure", arb_measure(ARB_WIDE_BVH, mesh, &options, scratch, scratch_bytes, &capacity, &error), &error);
    memory = allocate_aligned(capacity.index_bytes, &memory_block);

    /* 3. Build. The bytes are the index, and the handle is a view of them. */
    check("build",
          arb_build(&index, ARB_WIDE_BVH, mesh, &options, memory, capacity.index_bytes, scratch, scratch_bytes, &error),
          &error);
    free(scratch_block);

    check("describe", arb_describe(&index, &description), NULL);
    file = fopen(path, "wb");
    if (!file || fwrite(description.bytes, 1, description.byte_count, file) != description.byte_count || fclose(file)) {
        fail(path, "cannot be written");
    }
    check("close", arb_close(&index), NULL);
    free(memory_block);
}

/* Fills `index` from a file; returns the block of memory that it borrows. */
static void *read_and_open(const char *path, arb_index *index) {
    arb_error error;
    void *bytes, *block;
    long length;
    FILE *file = fopen(path, "rb");
    if (!file || fseek(file, 0, SEEK_END) || (length = ftell(file)) < 0 || fseek(file, 0, SEEK_SET)) {
        fail(path, "cannot be read");
        return NULL;
    }
    bytes = allocate_aligned((size_t)length, &block);
    if (fread(bytes, 1, (size_t)length, file) != (size_t)length) {
        fail(path, "cannot be read");
    }
    fclose(file);
    check(path, arb_open(index, bytes, (size_t)length, NULL, &error), &error);
    return block;
}

/* --- Rays -------------------------------------------------------------------------------------------------------- */

/* Draws a multiple of 2^-10 from -1 up to 1, by xorshift (Marsaglia 2003). */
static float draw(void) {
    static uint32_t state = 1;
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return (float)(state >> 21) / 1024.0f - 1.0f;
}

/* Makes rays from around the mesh to points in its box. Products and sums are rounded one by one. */
static void make_rays(const arb_mesh *mesh, arb_ray *rays, size_t count) {
    float centre[3] = {0, 0, 0}, half[3] = {0, 0, 0};
    size_t i;
    int axis;
    for (axis = 0; axis < 3; axis++) {
        float low = INFINITY, high = -INFINITY;
        for (i = 0; i < mesh->vertex_count; i++) {
            float coordinate = mesh->vertices[3 * i + (size_t)axis];
            low = coordinate < low ? coordinate : low;
            high = coordinate > high ? coordinate : high;
        }
        if (low <= high) {
            centre[axis] = (low + high) * 0.5f;
            half[axis] = (high - low) * 0.5f;
        }
    }
    for (i = 0; i < count; i++) {
        for (axis = 0; axis < 3; axis++) {
            float from = draw() * half[axis] * 2.0f, to = draw() * half[axis];
            float origin = centre[axis] + from, target = centre[axis] + to;
            rays[i].origin[axis] = origin;
            rays[i].direction[axis] = target - origin;
        }
        rays[i].t_min = 0.0f;
        rays[i].t_max = INFINITY;
    }
}

/* --- Digest: FNV-1a, 64 bits, of the four words of each hit, lowest byte first ------------------------------------ */

static uint64_t digest_of(const arb_hit *hits, size_t count) {
    uint64_t digest = 0xcbf29ce484222325u;
    size_t i;
    for (i = 0; i < count; i++) {
        uint32_t words[4];
        int word, byte;
        memcpy(words, &hits[i], sizeof words);
        for (word = 0; word < 4; word++) {
            for (byte = 0; byte < 4; byte++) {
                digest = (digest ^ (words[word] >> (8 * byte) & 0xff)) * 0x100000001b3u;
            }
        }
    }
    return digest;
}

int main(int argument_count, char **arguments) {
    float(*vertices)[3];
    uint32_t(*corners)[3];
    arb_mesh mesh;
    arb_index index;
    arb_description description;
    arb_error error;
    arb_counters counters = {0, 0};
    size_t i, hit_count = 0, occluded_count = 0, scratch_bytes = arb_batch_scratch_bytes();
    size_t ray_count = argument_count > 3 ? strtoul(arguments[3], NULL, 10) : 1000;
    arb_ray *rays = allocate(ray_count * sizeof *rays);
    arb_hit *hits = allocate(ray_count * sizeof *hits);
    bool *occluded = allocate(ray_count * sizeof *occluded);
    void *block, *scratch = allocate(scratch_bytes); /* what is in it does not matter */
    uint64_t digest;

    if (argument_count < 3) {
        fail("usage", "mesh_to_index MESH.obj INDEX.arb [RAYS]");
    }
    check("version", arb_check_abi(ARB_ABI_VERSION), NULL);
    read_mesh(arguments[1], &vertices, &corners, &mesh);
    build_and_write(&mesh, arguments[2]);
    block = read_and_open(arguments[2], &index);
    check("describe", arb_describe(&index, &description), NULL);

    /* Many rays at once. Each thread would have a scratch of its own. */
    make_rays(&mesh, rays, ray_count);
    check("closest", arb_closest_each(&index, rays, ray_count, hits, scratch, scratch_bytes, &error), &error);
    check("occluded", arb_occluded_each(&index, rays, ray_count, occluded, scratch, scratch_bytes, &error), &error);

    /* One ray after the other, with its work counted: the same hits. */
    for (i = 0; i < ray_count; i++) {
        arb_hit hit;
        check("ray", arb_closest_counted(&index, &rays[i], &hit, &counters), NULL);
        if (memcmp(&hit, &hits[i], sizeof hit) != 0 || (hit.triangle != ARB_NO_TRIANGLE) != occluded[i]) {
            fail("ray", "the answers differ");
        }
        hit_count += hit.triangle != ARB_NO_TRIANGLE;
        occluded_count += occluded[i];
    }

    /* Two words of 32 bits, because not every C library prints 64. Nodes and tests are below 2^32 here. */
    digest = digest_of(hits, ray_count);
    printf("%s: %lu triangles, %lu bytes, %lu rays, %lu hit, %lu occluded, %lu nodes, %lu tests, hits=%08lx%08lx\n",
           arb_kind_name(description.kind), (unsigned long)description.triangle_count,
           (unsigned long)description.byte_count, (unsigned long)ray_count, (unsigned long)hit_count,
           (unsigned long)occluded_count, (unsigned long)counters.nodes_visited, (unsigned long)counters.triangle_tests,
           (unsigned long)(digest >> 32), (unsigned long)(digest & 0xffffffff));

    free(block);
    free(scratch);
    free(occluded);
    free(hits);
    free(rays);
    free(corners);
    free(vertices);
    return 0;
}
