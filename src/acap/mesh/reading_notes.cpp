// SPDX-License-Identifier: MIT
#include "reading_notes.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

std::string name_of(PassedOver::Kind kind, std::int64_t count) {
    if (kind == PassedOver::Kind::small_face) {
        return fmt::format("{} of fewer than three corners", count == 1 ? "face" : "faces");
    }
    return count == 1 ? "unknown statement" : "unknown statements";
}

bool has_polygons(const PolygonMesh& mesh) { return mesh.corners.size() != 3 * mesh.face_count(); }

}  // namespace

void ReadingNotes::add(int index, const PolygonMesh& mesh) {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const PassedOver& found : mesh.passed_over) passed_over_[found.kind][index] = found;
    const auto note_unused = [&](const std::string& what) {
        int& first = unused_.try_emplace(what, index).first->second;
        first = std::min(first, index);
    };
    for (const std::string& what : mesh.unused) note_unused(what);
    if (has_polygons(mesh)) note_unused("polygons of more than three corners (split)");
}

std::vector<std::string> ReadingNotes::warnings(const std::vector<std::string>& paths) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::vector<std::string> sentences;
    const std::size_t file_count = std::set<std::string>(paths.begin(), paths.end()).size();
    for (const auto& [kind, files] : passed_over_) {
        std::int64_t count = 0;
        std::set<std::string>
            counted;  // a file may be there twice, as the reference and as a shape
        for (const auto& [index, found] : files) {
            if (counted.insert(paths[at(index)]).second) count += found.count;
        }
        const auto& [index, first] = *files.begin();
        const std::string where =
            file_count == 1 ? "" : fmt::format(" in {} of {} files", counted.size(), file_count);
        sentences.push_back(fmt::format("{} {}{} passed over, the first in {}, {}", count,
                                        name_of(kind, count), where, paths[at(index)],
                                        first.first));
    }
    return sentences;
}

std::vector<std::string> ReadingNotes::unused() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::vector<std::string> names;
    for (const auto& [name, first] : unused_) names.push_back(name);
    std::stable_sort(names.begin(), names.end(),
                     [&](const auto& a, const auto& b) { return unused_.at(a) < unused_.at(b); });
    return names;
}

}  // namespace mscomp
