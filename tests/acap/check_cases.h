// SPDX-License-Identifier: MIT
// What the tests of check share: a folder of shapes, and access to findings.
#pragma once

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "acap_cases.h"
#include "base/temporary_folder.h"
#include "mscomp/acap/check.h"

namespace mscomp::cases {

/// Shapes written as frame_0.obj, frame_1.obj, ... and looked at.
class CheckedShapes {
  public:
    void add(const TriangleMesh& mesh) {
        add_as("frame_" + std::to_string(paths_.size()) + ".obj", mesh);
    }
    void add_as(const std::string& name, const TriangleMesh& mesh) {
        std::ostringstream text;
        text.precision(17);
        for (const Point& p : mesh.vertices)
            text << "v " << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
        for (const Face& f : mesh.faces) {
            text << "f " << f[0] + 1 << ' ' << f[1] + 1 << ' ' << f[2] + 1 << '\n';
        }
        add_text(name, text.str());
    }
    void add_text(const std::string& name, const std::string& text) {
        paths_.push_back(folder_.put(name, text));
    }
    void add_missing(const std::string& name) { paths_.push_back(folder_ / name); }

    const std::vector<std::string>& paths() const { return paths_; }
    std::string path(const std::string& name) const { return folder_ / name; }
    CheckReport check(const CheckOptions& options = {}) const {
        return check_meshes(paths_, options);
    }

  private:
    TemporaryFolder folder_;
    std::vector<std::string> paths_;
};

/// The finding of that kind; one with count 0 if there is none.
inline Finding finding(const CheckReport& report, const std::string& kind) {
    const auto found = std::find_if(report.findings.begin(), report.findings.end(),
                                    [&](const Finding& f) { return f.kind == kind; });
    return found == report.findings.end() ? Finding{} : *found;
}
inline std::int64_t count_of(const CheckReport& report, const std::string& kind) {
    return finding(report, kind).count;
}

inline std::string kinds_of(const CheckReport& report) {
    std::string kinds;
    for (const Finding& found : report.findings) kinds += found.kind + " ";
    return kinds;
}

/// What `check` says of `shape` beside `reference`.
inline CheckReport check_pair(const TriangleMesh& reference, const TriangleMesh& shape) {
    CheckedShapes shapes;
    shapes.add(reference);
    shapes.add(shape);
    return shapes.check();
}

inline TriangleMesh renumbered(TriangleMesh mesh, const std::vector<int>& source) {
    const std::vector<Point> before = mesh.vertices;
    for (std::size_t i = 0; i < before.size(); ++i) mesh.vertices[i] = before[at(source[i])];
    return mesh;
}

/// Vertex i gets the position of vertex i + by, cyclically.
inline TriangleMesh shifted(const TriangleMesh& mesh, int by) {
    std::vector<int> source;
    for (int i = 0; i < mesh.vertex_count(); ++i) {
        source.push_back((i + by + mesh.vertex_count()) % mesh.vertex_count());
    }
    return renumbered(mesh, source);
}

/// The `size` vertices nearest to `first`, ring by ring, in another order.
inline TriangleMesh shuffled_patch(const TriangleMesh& mesh, const OneRings& rings, int first,
                                   int size, int seed) {
    std::vector<int> patch{first};
    for (std::size_t n = 0; n < patch.size(); ++n) {
        const auto vertex = at(patch[n]);
        for (int k = rings.offsets[vertex]; k < rings.offsets[vertex + 1]; ++k) {
            const int neighbor = rings.neighbors[at(k)];
            if (static_cast<int>(patch.size()) == size) break;
            if (std::ranges::find(patch, neighbor) == patch.end()) patch.push_back(neighbor);
        }
    }
    std::vector<int> source;
    for (int i = 0; i < mesh.vertex_count(); ++i) source.push_back(i);
    const std::vector<int> order = CounterRandom(static_cast<std::uint64_t>(seed), 7)
                                       .permutation(static_cast<int>(patch.size()));
    for (std::size_t n = 0; n < patch.size(); ++n) source[at(patch[n])] = patch[at(order[n])];
    return renumbered(mesh, source);
}

inline TriangleMesh exchanged(TriangleMesh mesh, int a, int b) {
    std::swap(mesh.vertices[at(a)], mesh.vertices[at(b)]);
    return mesh;
}

}  // namespace mscomp::cases
