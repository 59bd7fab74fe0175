// SPDX-License-Identifier: MIT
#include "model_arrays.h"

#include <algorithm>
#include <bit>
#include <cstdint>

#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"

namespace mscomp::nn {
namespace {

/// How an array is made up of rows that can be brought to another order of the vertices one by
/// one: the values of one component at all vertices.
struct ComponentRows {
    std::int64_t count = 0, size = 0, width = 0;

    /// None where the array is not about vertices.
    explicit ComponentRows(const Extents& extents) {
        if (extents.size() != 4) return;
        count = extents[0] * extents[1];
        width = extents[3];
        size = extents[2] * width;
    }
};

/// Calls body(inner vertex, vertex of the user) for all vertices, in parallel over chunks.
template <class Body>
void for_vertices(const Chunks& chunks, const VertexOrder& order, const Body& body) {
    parallel_for(chunks.count(), [&](std::int64_t chunk) {
        for (std::int64_t user = chunks.begin(chunk); user < chunks.end(chunk); ++user) {
            body(order.to_internal[at(user)], user);
        }
    });
}

Chunks chunks_of(const VertexOrder& order) { return {order.vertex_count(), std::int64_t{1} << 14}; }

}  // namespace

void add_inner(StoredArrays& arrays, const std::string& name, const Extents& extents,
               std::span<const float> inner, const VertexOrder& order) {
    const ComponentRows rows(extents);
    if (rows.count == 0) return arrays.add<float>(name, extents, inner);
    arrays.add(name, DataType::f32, extents, [=, &order](StoredArray& to) {
        std::vector<float> row(at(rows.size));
        for (std::int64_t k = 0; k < rows.count; ++k) {
            const float* from = inner.data() + k * rows.size;
            for_vertices(chunks_of(order), order, [&](std::int64_t v, std::int64_t u) {
                std::copy_n(from + v * rows.width, rows.width, row.data() + u * rows.width);
            });
            to.write(k * rows.size, std::span<const float>(row));
        }
    });
}

void read_inner(const SafetensorsFile& file, const std::string& name, const Extents& extents,
                const VertexOrder& order, std::span<float> inner) {
    // -0 is not 0 here.
    const auto same_bits = [](float a, float b) {
        return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
    };
    const std::span<const float> all = file.data<float>(name, extents);
    const ComponentRows rows(extents);
    if (rows.count == 0) {
        std::ranges::copy(all, inner.begin());
        return;
    }
    const Chunks chunks = chunks_of(order);
    for (std::int64_t k = 0; k < rows.count; ++k) {
        const float* from = all.data() + k * rows.size;
        float* to = inner.data() + k * rows.size;
        for_vertices(chunks, order, [&](std::int64_t v, std::int64_t u) {
            const auto width = at(rows.width);
            const std::span<const float> source(from + u * rows.width, width);
            const std::span<float> target(to + v * rows.width, width);
            if (!std::ranges::equal(source, target, same_bits))
                std::ranges::copy(source, target.begin());
        });
        file.forget(std::as_bytes(std::span(from, at(rows.size))));
    }
}

}  // namespace mscomp::nn
