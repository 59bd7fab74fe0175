// SPDX-License-Identifier: MIT
#include <cmath>

#include "base/temporary_folder.h"
#include "fuzz/feature_promises.h"
#include "fuzz/memory_file.h"
#include "fuzz/promises.h"
#include "fuzz/shape_promises.h"
#include "fuzz/targets.h"
#include "mscomp/convert/array_files.h"

namespace mscomp::fuzz {
namespace {

/// What files without a mesh of their own are given: a tetrahedron.
Supplement tetrahedron() {
    Supplement supplement;
    supplement.reference_path = "input (reference)";
    supplement.reference = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                            {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
    return supplement;
}

void check_round_trip(const Contents& contents, const std::string& path) {
    if (contents.features) {
        write_npz(path, *contents.features);
        const Contents again = read_npz(path, {});
        require(again.features.has_value(), "features survive");
        check_same(*again.features, *contents.features);
    } else {
        write_npz(path, *contents.shapes);
        check_same(*read_npz(path, {}).shapes, *contents.shapes);
    }
}

/// A refusal names the file, or the reference that was to supply what it lacks.
std::optional<Contents> contents_unless_refused(const std::string& path,
                                                const Supplement& supplement) {
    try {
        return read_npz(path, supplement);
    } catch (const InputError& error) {
        const bool is_of_reference =
            std::string_view(error.what()).starts_with(supplement.reference_path);
        check_refusal(error, is_of_reference ? supplement.reference_path : path);
        return std::nullopt;
    }
}

}  // namespace

void check_npz(std::span<const std::byte> input) {
    static const MemoryFile memory;
    static const TemporaryFolder folder;
    static const Supplement supplement = tetrahedron();
    const std::string path = memory.filled_with(input);
    const auto contents = contents_unless_refused(path, supplement);
    if (!contents) return;
    require(contents->features.has_value() != (contents->shapes != nullptr),
            "a file holds features or shapes");
    for (const std::string& note : contents->notes) check_shown(note);
    if (contents->features) check_sound(*contents->features);
    if (contents->shapes && !unless_refused(path, [&] {
            check_sound(*contents->shapes);
            return true;
        })) {
        return;  // a number that is not finite is found when its shape is read
    }
    check_round_trip(*contents, folder / "again.npz");
}

}  // namespace mscomp::fuzz
