// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// error: extraction would stop. warning: it works around it, or what is learnt would suffer.
/// note: worth knowing.
enum class Severity { error, warning, note };
std::string to_string(Severity severity);

/// Where something was found. Vertices and faces count from 1, as in OBJ (faces as the file has
/// them, before polygons are split); what does not apply is 0 or empty.
struct CheckPlace {
    std::string text{};  // the place in words
    std::string file{}, other_file{};
    std::int64_t line = 0, column = 0;
    int vertex = 0, other_vertex = 0, face = 0;
    std::int64_t count = 0;  // how often in this file, or how large
};

/// Places kept of one finding; its count goes on.
constexpr std::size_t kPlacesKept = 100;

/// Everything of one kind, over all files.
struct Finding {
    Severity severity = Severity::note;
    std::string kind;                // stable, for programs: "repeated_frames"
    std::int64_t count = 0;          // of what the sentence counts first
    std::string sentence;            // what was found
    std::string advice;              // what it means and what to do
    std::vector<CheckPlace> places;  // the first kPlacesKept
};

/// The largest |S - I| entry of all shapes and what nearly all vertices stay below.
struct StretchRange {
    double largest = 0;
    std::string file;
    int vertex = 0;         // from 1
    double most_below = 0;  // 99.9 % quantile over vertices and shapes, within 2 %
};

/// What is in a set of meshes and everything that is wrong or odd about it.
struct CheckReport {
    int files = 0;
    int usable = 0;         // read, with the connectivity of the reference
    std::string reference;  // what the others were compared with; empty if no file can be read
    int vertices = 0, faces = 0, edges = 0, components = 0, boundary_loops = 0;
    Point lowest{}, highest{};   // corners of the reference's bounding box, in its unit
    double unit_ball_scale = 0;  // 1 / largest distance of a reference vertex from their centroid
    StretchRange stretch;
    std::vector<Finding> findings;  // errors first, then warnings, then notes

    int count(Severity severity) const;  // findings of that severity
};

struct CheckOptions {
    int reference_index = 0;     // of the shape the others are compared with
    std::string reference_file;  // used instead where it is given
};

/// Looks at every file of a set, whatever is wrong with the ones before, and keeps numbers instead
/// of positions, so memory does not grow with the set but for some hundred bytes a shape. If the
/// reference cannot be read, the first file that can be takes its place. The same for any number
/// of threads. `progress` may throw to stop. Throws UsageError if there are no paths or the index
/// is none of theirs.
CheckReport check_meshes(const std::vector<std::string>& paths, const CheckOptions& options = {},
                         const std::function<void(int done, int total)>& progress = {});

}  // namespace mscomp
