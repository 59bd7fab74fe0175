// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "mscomp/base/vertex_places.h"

namespace mscomp {

/// Files named by `inputs` — files, folders (all their .obj, .ply, .off but hidden ones; not those
/// of folders in them) or globs (*, ?, [...]) — in natural order. Throws UsageError when an input
/// matches nothing or two inputs name the same file.
std::vector<std::string> expand_inputs(const std::vector<std::string>& inputs);

/// What the shapes of `paths` are called, all differently: the stem of the file; where stems
/// repeat, with the folders before it that not all paths have in common ("take1_frame"). What is
/// still the same gets "-2", "-3", ...
std::vector<std::string> shape_names(const std::vector<std::string>& paths);

/// Meshes of one connectivity in the order given; N shapes, V vertices, F faces.
struct MeshSequence {
    std::vector<std::string> names;          // (N) as shape_names has them
    std::vector<std::vector<Point>> shapes;  // (N) of (V) positions
    std::vector<Face> faces;                 // (F) of the first file

    int shape_count() const { return static_cast<int>(shapes.size()); }
    int vertex_count() const {
        return shapes.empty() ? 0 : static_cast<int>(shapes.front().size());
    }
};

/// Reads `paths` in parallel and makes sure that all have the connectivity of the first: the same
/// V, and the same faces (the order of faces and the starting corner may differ). Throws InputError
/// naming the file, got and wanted.
MeshSequence read_sequence(const std::vector<std::string>& paths);

/// What is odd about a connectivity but can be worked with.
struct ConnectivityReport {
    int vertex_count = 0, face_count = 0;
    int components = 0;  // of the faces; isolated vertices are not counted here
    int boundary_edges = 0;
    int boundary_loops = 0;         // pieces the boundary edges form; holes that touch count once
    int non_manifold_edges = 0;     // more than two faces, or two faces of opposite orientation
    int non_manifold_vertices = 0;  // whose faces, over shared edges, form several fans
    int duplicate_faces = 0;
    int degenerate_faces = 0;   // a vertex twice in one face
    int isolated_vertices = 0;  // in no face
    int faces_beside = 0;       // kept out of the half-edges: degenerate or not manifold
    std::vector<std::string>
        warnings;  // one sentence each: count and first place, from 1 as in OBJ
};

/// One-rings of a SurfaceMesh, and what is odd about it.
struct SurfaceConnectivity {
    OneRings rings;
    ConnectivityReport report;
};
/// `face_numbers` (F) tell which face of the file, from 1, each triangle is of; empty: each is its
/// own. Edges, boundaries, fans and components are those of the surface of `places`, where vertices
/// that share one are its lowest; faces and vertices without a face are odd as in the file. Throws
/// MeshError if a face refers to a vertex outside 0 .. V-1.
SurfaceConnectivity analyze_connectivity(int vertex_count, const std::vector<Face>& faces,
                                         const std::vector<int>& face_numbers = {},
                                         const VertexPlaces& places = {});

}  // namespace mscomp
