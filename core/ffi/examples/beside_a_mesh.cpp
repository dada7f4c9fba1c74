// An index beside a mesh, in static memory: no heap, no exceptions, as on a device.
//
//     beside_a_mesh MESH.obj
//
// The lean BVH has no copy of the triangles; it reads them in the program's own arrays. Reads `v x y z` and `f a b c`
// lines of an OBJ file. Prints a line with the digest of all hits: that of mesh_to_index.c, since an answer does not
// depend on the kind of index.
#include "arboleda.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

constexpr std::size_t most_vertices = 2000, most_triangles = 2000, ray_count = 1000;

/// Ends the program unless a function of the library succeeded.
void check(arb_status status, const char *message) {
    if (status != ARB_OK) {
        std::fprintf(stderr, "%s\n", message);
        std::exit(EXIT_FAILURE);
    }
}

/// Memory of a fixed size in which an index or the scratch of a build can lie.
template <std::size_t bytes> struct alignas(ARB_ALIGNMENT) Memory {
    std::array<unsigned char, bytes> array;
};

/// Open index that closes itself, so that a later use of the handle is an error.
class Index {
public:
    Index() = default;
    Index(const Index &) = delete;
    Index &operator=(const Index &) = delete;
    ~Index() { arb_close(&handle); }

    /// Builds an index of `mesh`, which it borrows as long as it lives.
    template <std::size_t bytes, std::size_t scratch_bytes>
    void build(arb_kind kind, const arb_mesh &mesh, const arb_options &options, Memory<bytes> &memory,
               Memory<scratch_bytes> &scratch) {
        arb_error error;
        check(arb_build(&handle, kind, &mesh, &options, &memory, bytes, &scratch, scratch_bytes, &error),
              error.message);
    }

    /// Finds the closest hit of a ray; its triangle is ARB_NO_TRIANGLE if there is none.
    arb_hit closest(const arb_ray &ray) const {
        arb_hit hit;
        const arb_status status = arb_closest(&handle, &ray, &hit);
        check(status, arb_status_text(status));
        return hit;
    }

    arb_description description() const {
        arb_description description;
        const arb_status status = arb_describe(&handle, &description);
        check(status, arb_status_text(status));
        return description;
    }

private:
    arb_index handle{};
};

/// Mesh in arrays of a fixed size.
struct Mesh {
    std::array<float, 3 * most_vertices> vertices;
    std::array<std::uint32_t, 3 * most_triangles> corners;
    arb_mesh arrays;

    void read(const char *path) {
        std::FILE *file = std::fopen(path, "r");
        check(file ? ARB_OK : ARB_NULL_POINTER, "the mesh cannot be opened");
        std::array<char, 256> line;
        arrays = arb_mesh{};
        while (std::fgets(line.data(), static_cast<int>(line.size()), file)) {
            const char *text = line.data() + 2;
            if (std::strncmp(line.data(), "v ", 2) == 0) {
                check(arrays.vertex_count < most_vertices ? ARB_OK : ARB_OTHER_REASON, "too many vertices");
                float *vertex = &vertices[3 * arrays.vertex_count++];
                const int found = std::sscanf(text, "%f %f %f", vertex, vertex + 1, vertex + 2);
                check(found == 3 ? ARB_OK : ARB_OTHER_REASON, "a vertex needs three numbers");
            } else if (std::strncmp(line.data(), "f ", 2) == 0) {
                check(arrays.triangle_count < most_triangles ? ARB_OK : ARB_OTHER_REASON, "too many triangles");
                unsigned long a, b, c;
                const int found = std::sscanf(text, "%lu %lu %lu", &a, &b, &c);
                check(found == 3 ? ARB_OK : ARB_OTHER_REASON, "a face needs three vertices");
                std::uint32_t *corner = &corners[3 * arrays.triangle_count++];
                corner[0] = static_cast<std::uint32_t>(a - 1);
                corner[1] = static_cast<std::uint32_t>(b - 1);
                corner[2] = static_cast<std::uint32_t>(c - 1);
            }
        }
        std::fclose(file);
        arrays.vertices = vertices.data();
        arrays.corners = corners.data();
    }
};

/// Draws a multiple of 2^-10 from -1 up to 1, by xorshift (Marsaglia 2003).
float draw() {
    static std::uint32_t state = 1;
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return static_cast<float>(state >> 21) / 1024.0f - 1.0f;
}

/// The box around a mesh, as centre and half sides.
struct Box {
    std::array<float, 3> centre{}, half{};

    explicit Box(const arb_mesh &mesh) {
        for (std::size_t axis = 0; axis < 3; axis++) {
            float low = INFINITY, high = -INFINITY;
            for (std::size_t i = axis; i < 3 * mesh.vertex_count; i += 3) {
                low = std::fmin(low, mesh.vertices[i]);
                high = std::fmax(high, mesh.vertices[i]);
            }
            centre[axis] = (low + high) * 0.5f;
            half[axis] = (high - low) * 0.5f;
        }
    }

    /// Makes a ray from around the box to a point in it. Products and sums are rounded one by one.
    arb_ray ray() const {
        arb_ray ray{};
        for (std::size_t axis = 0; axis < 3; axis++) {
            const float from = draw() * half[axis] * 2.0f;
            const float to = draw() * half[axis];
            const float origin = centre[axis] + from, target = centre[axis] + to;
            ray.origin[axis] = origin;
            ray.direction[axis] = target - origin;
        }
        ray.t_max = INFINITY;
        return ray;
    }
};

/// Adds a hit to a digest, FNV-1a of 64 bits: its four words, lowest byte first.
void add(std::uint64_t &digest, const arb_hit &hit) {
    std::array<std::uint32_t, 4> words;
    std::memcpy(words.data(), &hit, sizeof words);
    for (const std::uint32_t word : words) {
        for (int bit = 0; bit < 32; bit += 8) {
            digest = (digest ^ (word >> bit & 0xff)) * 0x100000001b3u;
        }
    }
}

Mesh mesh;
Memory<32 * 1024> memory;
Memory<512 * 1024> scratch;

} // namespace

int main(int argument_count, char **arguments) {
    check(argument_count == 2 ? ARB_OK : ARB_OTHER_REASON, "usage: beside_a_mesh MESH.obj");
    check(arb_check_abi(ARB_ABI_VERSION), "the library has another version than the header");
    mesh.read(arguments[1]);

    arb_options options;
    check(arb_options_default(&options, sizeof options), "options");
    options.beside = 1;
    Index index;
    index.build(ARB_LEAN_BVH, mesh.arrays, options, memory, scratch);

    const Box box(mesh.arrays);
    std::uint64_t digest = 0xcbf29ce484222325u;
    unsigned long hit_count = 0;
    for (std::size_t i = 0; i < ray_count; i++) {
        const arb_hit hit = index.closest(box.ray());
        hit_count += hit.triangle != ARB_NO_TRIANGLE;
        add(digest, hit);
    }
    const arb_description description = index.description();
    std::printf("%s: %lu triangles, %lu bytes, %lu rays, %lu hit, hits=%08lx%08lx\n", arb_kind_name(description.kind),
                static_cast<unsigned long>(description.triangle_count),
                static_cast<unsigned long>(description.byte_count), static_cast<unsigned long>(ray_count), hit_count,
                static_cast<unsigned long>(digest >> 32), static_cast<unsigned long>(digest & 0xffffffff));
    return 0;
}
