// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "check_frame.h"
#include "mscomp/acap/check.h"
#include "mscomp/acap/mesh/shape_source.h"
#include "mscomp/base/error.h"

namespace mscomp {

/// "1 face" or "7 faces".
std::string counted(std::int64_t count, std::string_view one, std::string_view many);

/// A finding that grows place by place; of no use while nothing was added.
class FindingBuilder {
  public:
    FindingBuilder(Severity severity, std::string kind);

    /// Counts `count` more and keeps the place while there is room.
    void add(CheckPlace place, std::int64_t count = 1);
    std::int64_t count() const { return finding_.count; }
    int places_added() const { return places_added_; }  // kept or not
    /// Appends the finding to `findings` unless nothing was added.
    void finish(std::string sentence, std::string advice, std::vector<Finding>& findings);

  private:
    Finding finding_;
    int places_added_ = 0;
};

/// Why a file cannot be used.
struct Refusal {
    std::string kind;  // of the finding it belongs to
    std::string message;
    FilePosition where;
    int vertex_count = 0;  // if that is what differs
};

struct CheckedFile {
    std::string path;
    std::string label;  // how places name it: without its folder where that is clear
    std::optional<Refusal> refusal;
    FrameFacts facts;  // if there is no refusal
};

/// `paths` with what places call them: the name without the folder if no two are equal.
std::vector<CheckedFile> checked_files(const std::vector<std::string>& paths);

/// Files that cannot be used, by kind.
void find_refusals(const std::vector<CheckedFile>& files, const CheckReport& report,
                   std::vector<Finding>& findings);

/// What is odd about the faces: places of everything the report counts. `face_numbers` (F) are
/// those of the file, from 1; for `places` see analyze_connectivity.
void find_connectivity(int vertex_count, const std::vector<Face>& faces,
                       const std::vector<int>& face_numbers, const VertexPlaces& places,
                       CheckReport& report, std::vector<Finding>& findings);

/// Vertices that lie on others in every shape, given the lowest one that each (V) lies on.
void find_coincident(const std::vector<int>& lowest, const std::string& path,
                     std::vector<Finding>& findings);

/// What is odd about the surface of the reference.
void find_reference_geometry(const FrameMeter& meter, const std::vector<int>& face_numbers,
                             const std::string& path, std::vector<Finding>& findings);

/// What is odd about single shapes: order of the vertices, strays, mirror images, unit, place,
/// range of the features, and more faces without area or folds than the reference has.
void find_in_shapes(const std::vector<CheckedFile>& files, const std::vector<int>& face_numbers,
                    const FrameFacts& reference, const CheckReport& report,
                    std::vector<Finding>& findings);

/// Shapes that occur more than once; candidates for rigid copies are read again from `source`,
/// where shape i+1 is file i and shape 0 the reference.
void find_copies(const std::vector<CheckedFile>& files, const MeshFiles& source,
                 const FrameFacts& reference, double radius, std::vector<Finding>& findings);

/// Gaps, repetitions and order of the numbers in file names.
void find_numbering(const std::vector<CheckedFile>& files, std::vector<Finding>& findings);

}  // namespace mscomp
