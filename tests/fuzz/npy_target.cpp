// SPDX-License-Identifier: MIT
#include <cmath>

#include "fuzz/promises.h"
#include "fuzz/targets.h"
#include "mscomp/convert/npy.h"

namespace mscomp::fuzz {
namespace {

/// The same array written by us, where its order in the file is C.
void check_header(const NpyArray& array) {
    const std::string header = npy_header(array.type, array.shape, array.item_size);
    require(header.size() % 64 == 0, "data begin at 64 bytes");
    const std::string file = header + std::string(text_of(array.data));
    const NpyArray again = parse_npy(bytes_of(file), "again");
    require(again.type == array.type && again.item_size == array.item_size &&
                again.shape == array.shape && text_of(again.data) == text_of(array.data),
            "an array survives writing and reading");
}

void check_texts(const std::vector<std::string>& texts) {
    const std::string file = npy_texts(texts);
    require(parse_npy(bytes_of(file), "again").texts() == texts, "text survives");
}

}  // namespace

void check_npy(std::span<const std::byte> input) {
    const auto array = unless_refused("input", [&] { return parse_npy(input, "input"); });
    if (!array) return;
    check_header(*array);
    const auto count = static_cast<std::size_t>(array->count());
    const std::int64_t rows = array->shape.empty() ? 1 : array->shape[0];
    const auto right_size = [&](const auto& values) {
        require(!values || values->size() == count, "all entries are read");
    };
    const auto doubles = unless_refused("input", [&] { return array->doubles(0, rows); });
    right_size(doubles);
    if (doubles) {
        for (const double x : *doubles) require(std::isfinite(x), "numbers are finite");
    }
    right_size(unless_refused("input", [&] { return array->doubles(0, rows, true); }));
    right_size(unless_refused("input", [&] { return array->floats(0, rows); }));
    right_size(unless_refused("input", [&] { return array->integers(); }));
    const auto texts = unless_refused("input", [&] { return array->texts(); });
    right_size(texts);
    if (texts) check_texts(*texts);
    // Row by row it is the same.
    if (!doubles || rows > 64) return;
    std::vector<double> joined;
    for (std::int64_t row = 0; row < rows; ++row) {
        const std::vector<double> part = array->doubles(row, 1);
        joined.insert(joined.end(), part.begin(), part.end());
    }
    require(same_bits(joined, *doubles), "rows are parts of the whole");
}

}  // namespace mscomp::fuzz
