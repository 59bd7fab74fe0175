// SPDX-License-Identifier: MIT
#include "mscomp/run/component_meshes.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/points.h"

namespace mscomp {
namespace {

/// Length of each row of `width` numbers.
std::vector<float> row_lengths(std::span<const float> rows, int width) {
    std::vector<float> lengths;
    for (std::size_t i = 0; i < rows.size(); i += at(width)) {
        float square = 0;
        for (const float x : rows.subspan(i, at(width))) square += x * x;
        lengths.push_back(std::sqrt(square));
    }
    return lengths;
}

float full_color_amount(const std::vector<float>& amount) {
    std::vector<float> moving;
    std::ranges::copy_if(amount, std::back_inserter(moving), [](float a) { return a > 0; });
    if (moving.empty()) return 0;
    const auto place = moving.begin() + static_cast<std::ptrdiff_t>((moving.size() - 1) * 98 / 100);
    std::nth_element(moving.begin(), place, moving.end());
    return *place;
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// Sum of the areas of the faces of every number in `parts` (V), those of its vertices alone.
std::map<int, double> part_areas(const TriangleMesh& mesh, const std::vector<int>& parts) {
    std::map<int, double> areas;
    for (const Face& face : mesh.faces) {
        const auto corner = [&](int i) { return at(face[at(i)]); };
        const int part = parts[corner(0)];
        if (parts[corner(1)] != part || parts[corner(2)] != part) continue;
        const Point a = minus(mesh.vertices[corner(1)], mesh.vertices[corner(0)]);
        const Point b = minus(mesh.vertices[corner(2)], mesh.vertices[corner(0)]);
        const Point normal = cross(a, b);
        areas[part] += std::hypot(normal[0], normal[1], normal[2]) / 2;
    }
    return areas;
}

/// The pieces of the mesh that are left without the vertices that change; those are pieces of one
/// vertex each.
std::vector<int> still_pieces(const TriangleMesh& mesh, const std::vector<float>& amount) {
    std::vector<Face> faces;
    for (const Face& face : mesh.faces) {
        if (std::ranges::all_of(face, [&](int v) { return amount[at(v)] == 0; })) {
            faces.push_back(face);
        }
    }
    return connected_components(one_rings_of_faces(mesh.vertex_count(), faces));
}

}  // namespace

ComponentMeshes::ComponentMeshes(const ModelContext& context, ShapeRows rows)
    : context_(context),
      reference_(context.reference),
      parts_(connected_components(
          one_rings_of_faces(context.reference.vertex_count(), context.reference.faces))),
      positions_(rows, context.reference, parse_edge_weights(context.weights),
                 VertexSolver::lossless) {}

std::vector<float> ComponentMeshes::reference_rows() const {
    std::vector<float> rows;
    for (const Point& p : reference_.vertices) {
        if (positions_.rows() == ShapeRows::features) {
            rows.insert(rows.end(), kReferenceFeature.begin(), kReferenceFeature.end());
        } else {
            for (const double x : p) rows.push_back(static_cast<float>(x));
        }
    }
    return rows;
}

TriangleMesh ComponentMeshes::mesh(std::span<const float> change) const {
    std::vector<float> rows = reference_rows();
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i] += change[i];
    TriangleMesh mesh{positions_.positions(rows), reference_.faces};
    if (positions_.rows() == ShapeRows::features)
        keep_still(mesh, row_lengths(change, kFeatureDim));
    return mesh;
}

void ComponentMeshes::keep_still(TriangleMesh& mesh, const std::vector<float>& amount) const {
    const std::vector<int> pieces = still_pieces(reference_, amount);
    const std::map<int, double> areas = part_areas(reference_, pieces);
    std::map<int, int> largest;  // of the pieces of each part
    for (std::size_t v = 0; v < pieces.size(); ++v) {
        const auto area = areas.find(pieces[v]);
        if (area == areas.end()) continue;
        const auto [entry, is_first] = largest.emplace(parts_[v], pieces[v]);
        if (!is_first && area->second > areas.at(entry->second)) entry->second = pieces[v];
    }
    // Parts without a still piece keep their place beside the part with the largest one.
    int leader = -1;
    for (const auto& [part, piece] : largest) {
        if (leader < 0 || areas.at(piece) > areas.at(largest.at(leader))) leader = part;
    }
    std::map<int, std::array<std::vector<double>, 3>> moves;
    for (std::size_t v = 0; v < pieces.size(); ++v) {
        const auto piece = largest.find(parts_[v]);
        if (leader >= 0 && (piece == largest.end() || piece->second != pieces[v])) continue;
        for (std::size_t x = 0; x < 3; ++x) {
            moves[leader < 0 ? leader : parts_[v]][x].push_back(mesh.vertices[v][x] -
                                                                reference_.vertices[v][x]);
        }
    }
    std::map<int, Point> move;
    for (auto& [part, of_axes] : moves) {
        for (std::size_t x = 0; x < 3; ++x) move[part][x] = median(std::move(of_axes[x]));
    }
    for (std::size_t v = 0; v < pieces.size(); ++v) {
        const auto own = move.find(parts_[v]);
        mesh.vertices[v] =
            minus(mesh.vertices[v], (own != move.end() ? own : move.find(leader))->second);
    }
}

ColoredShape ComponentMeshes::whole(const ColoredShape& shape) const {
    ColoredShape result{whole(shape.mesh), {}, shape.full_blue};
    if (shape.amount.empty()) return result;
    result.amount.assign(result.mesh.vertices.size(), 0.0F);
    context_.places.to_vertices(std::span<const float>(shape.amount), std::span(result.amount));
    return result;
}

ColoredShape ComponentMeshes::colored(std::span<const float> change) const {
    ColoredShape shape{mesh(change), row_lengths(change, row_width(positions_.rows())), 0};
    shape.full_blue = full_color_amount(shape.amount);
    return shape;
}

std::vector<float> ComponentMeshes::displacement(const TriangleMesh& mesh) const {
    std::vector<float> distance;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        const Point &p = mesh.vertices[v], &q = reference_.vertices[v];
        distance.push_back(static_cast<float>(std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2])));
    }
    return distance;
}

std::vector<std::array<float, 3>> colors_of(const ColoredShape& shape) {
    std::vector<std::array<float, 3>> colors;
    for (const float amount : shape.amount) {
        colors.push_back(white_to_blue(shape.full_blue > 0 ? amount / shape.full_blue : 0));
    }
    return colors;
}

void write_colored_ply(const std::string& path, const ColoredShape& shape) {
    std::vector<VertexColor> colors;
    const auto byte = [](float x) { return static_cast<std::uint8_t>(std::lround(255 * x)); };
    for (const auto& color : colors_of(shape)) {
        colors.push_back({byte(color[0]), byte(color[1]), byte(color[2])});
    }
    write_ply(path, shape.mesh, colors, shape.amount);
}

SheetView common_view(const TriangleMesh& reference, std::span<const ColoredShape> shapes,
                      int longer_side) {
    std::vector<Point> all = reference.vertices;
    for (const ColoredShape& shape : shapes) {
        all.insert(all.end(), shape.mesh.vertices.begin(), shape.mesh.vertices.end());
    }
    const View view = framed(fit_view(reference.vertices), all);
    const auto [width, height] = picture_size(view, longer_side);
    return {framed(view, all, static_cast<double>(width) / height), width, height};
}

Image picture_of(const ColoredShape& shape, const SheetView& view) {
    return render_mesh(shape.mesh, colors_of(shape), view.view, view.width, view.height);
}

}  // namespace mscomp
