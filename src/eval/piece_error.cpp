// SPDX-License-Identifier: MIT
#include "mscomp/eval/piece_error.h"

#include <cmath>
#include <limits>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

std::vector<Point> chosen(const std::vector<Point>& points, const std::vector<int>& which) {
    std::vector<Point> result;
    result.reserve(which.size());
    for (const int v : which) result.push_back(points[at(v)]);
    return result;
}

}  // namespace

PieceRmsError::PieceRmsError(const TriangleMesh& reference)
    : vertex_count_(reference.vertices.size()), scale_(unit_ball_scale(reference.vertices)) {
    if (reference.vertices.empty()) throw MeshError("E_rms of a reference without vertices");
    const std::vector<int> piece =
        connected_components(one_rings_of_faces(reference.vertex_count(), reference.faces));
    for (std::size_t v = 0; v < piece.size(); ++v) {
        if (at(piece[v]) == pieces_.size()) pieces_.emplace_back();
        pieces_[at(piece[v])].push_back(static_cast<int>(v));
    }
}

void PieceRmsError::add(const std::vector<Point>& truth, const std::vector<Point>& result) {
    if (truth.size() != vertex_count_ || result.size() != vertex_count_) {
        throw MeshError("a shape with another number of vertices than the reference");
    }
    for (const std::vector<int>& piece : pieces_) {
        for (const double d : vertex_distances(chosen(truth, piece), chosen(result, piece))) {
            squares_ += scale_ * scale_ * d * d;
        }
    }
    coordinates_ += 3.0 * static_cast<double>(vertex_count_);
}

double PieceRmsError::value() const {
    if (!(coordinates_ > 0)) return std::numeric_limits<double>::quiet_NaN();
    return 1000 * std::sqrt(squares_ / coordinates_);
}

}  // namespace mscomp
