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

}  // namespace

void check_npz(std::span<const std::byte> input) {
    static const MemoryFile memory;
    static const TemporaryFolder folder;
    static const Supplement supplement = tetrahedron();
    const std::string path = memory.filled_with(input);
    try {
        const auto contents = unless_refused(path, [&] { return read_npz(path, supplement); });
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
    } catch (const InputError& error) {
        check_refusal(error, supplement.reference_path);  // that has another number of vertices
    }
}

}  // namespace mscomp::fuzz
