// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dot.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/render/render.h"

namespace mscomp {
namespace {

/// Samples per pixel along each direction.
constexpr int kSamples = 3;
/// Pixel rows drawn together; each band owns its pixels.
constexpr int kBandRows = 16;
constexpr int kNothing = -1;

using Color = std::array<float, 3>;
constexpr Color kBackground{1, 1, 1};

Point normalized(const Point& p) {
    const double length = std::sqrt(dot(p, p));
    return length > 0 ? Point{p[0] / length, p[1] / length, p[2] / length} : Point{0, 0, 1};
}

/// A vertex as the viewer sees it: sample coordinates (y down), depth towards the viewer, and the
/// normal along right, up and towards the viewer.
struct Corner {
    double x = 0, y = 0, depth = 0;
    Point normal{0, 0, 0};
    Color color{1, 1, 1};
};

struct Scene {
    int width = 0, height = 0;  // in samples
    std::vector<Corner> corners;
    const std::vector<Face>* faces = nullptr;

    const Corner& corner(int face, std::size_t k) const {
        const Face& f = (*faces)[at(face)];
        return corners[at(f[k])];
    }
};

void check_input(const TriangleMesh& mesh, std::span<const Color> colors, int width, int height) {
    if (width <= 0 || height <= 0) {
        throw UsageError(fmt::format("render: a picture of {} x {} pixels", width, height));
    }
    if (mesh.vertices.empty() || mesh.faces.empty()) {
        throw MeshError(fmt::format("render: nothing to draw, the mesh has {} vertices, {} faces",
                                    mesh.vertices.size(), mesh.faces.size()));
    }
    if (!colors.empty() && colors.size() != mesh.vertices.size()) {
        throw MeshError(
            fmt::format("render: {} colours for {} vertices", colors.size(), mesh.vertices.size()));
    }
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        const Point& p = mesh.vertices[i];
        if (!std::isfinite(p[0] + p[1] + p[2])) {
            throw MeshError(fmt::format("render: vertex {} is ({}, {}, {}), wanted finite numbers",
                                        i, p[0], p[1], p[2]));
        }
    }
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        for (const int vertex : mesh.faces[f]) {
            if (vertex >= 0 && vertex < mesh.vertex_count()) continue;
            throw MeshError(
                fmt::format("render: face {} refers to vertex {}, the mesh has {} vertices", f,
                            vertex, mesh.vertex_count()));
        }
    }
}

/// Projects the vertices; normals are sums of face normals weighted by area.
Scene project(const TriangleMesh& mesh, std::span<const Color> colors, const View& view, int width,
              int height) {
    Scene scene{width * kSamples, height * kSamples, {}, &mesh.faces};
    const double scale = 0.5 * std::min(scene.width, scene.height) / view.half_extent;
    scene.corners.resize(mesh.vertices.size());
    std::vector<Point> seen(mesh.vertices.size());
    for (std::size_t i = 0; i < seen.size(); ++i) {
        const Point& p = mesh.vertices[i];
        const Point offset{p[0] - view.center[0], p[1] - view.center[1], p[2] - view.center[2]};
        for (std::size_t k = 0; k < 3; ++k) seen[i][k] = scale * dot(offset, view.axes[k]);
        Corner& corner = scene.corners[i];
        corner.x = 0.5 * scene.width + seen[i][0];
        corner.y = 0.5 * scene.height - seen[i][1];
        corner.depth = seen[i][2];
        if (!colors.empty()) corner.color = colors[i];
    }
    for (const Face& f : mesh.faces) {
        const Point& p = seen[at(f[0])];
        const Point& q = seen[at(f[1])];
        const Point& r = seen[at(f[2])];
        const Point u{q[0] - p[0], q[1] - p[1], q[2] - p[2]};
        const Point v{r[0] - p[0], r[1] - p[1], r[2] - p[2]};
        const Point normal{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                           u[0] * v[1] - u[1] * v[0]};
        for (const int i : f) {
            Point& sum = scene.corners[at(i)].normal;
            for (std::size_t k = 0; k < 3; ++k) sum[k] += normal[k];
        }
    }
    for (Corner& corner : scene.corners) corner.normal = normalized(corner.normal);
    return scene;
}

double twice_area(const Corner& a, const Corner& b, double x, double y) {
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

/// Shares of the three corners at a sample; the area keeps its sign, so that any side shows.
std::array<double, 3> shares_at(const Scene& scene, int face, double x, double y) {
    const Corner& a = scene.corner(face, 0);
    const Corner& b = scene.corner(face, 1);
    const Corner& c = scene.corner(face, 2);
    const double area = twice_area(a, b, c.x, c.y);
    return {twice_area(b, c, x, y) / area, twice_area(c, a, x, y) / area,
            twice_area(a, b, x, y) / area};
}

/// What is seen in some rows of samples: the nearest face at each, if any.
struct Band {
    int first_row = 0, rows = 0, width = 0;
    std::vector<double> depth;
    std::vector<int> face;
};

void draw_face(const Scene& scene, int face, Band& band) {
    const Corner& a = scene.corner(face, 0);
    const Corner& b = scene.corner(face, 1);
    const Corner& c = scene.corner(face, 2);
    // Written so that a face seen edge-on, without area, drops out.
    if (!(std::abs(twice_area(a, b, c.x, c.y)) > 0)) return;
    const auto clamped = [](double value, int low, int high) {
        return static_cast<int>(
            std::clamp(value, static_cast<double>(low), static_cast<double>(high)));
    };
    const int last_row = band.first_row + band.rows - 1;
    const int top = clamped(std::floor(std::min({a.y, b.y, c.y})), band.first_row, last_row);
    const int bottom = clamped(std::ceil(std::max({a.y, b.y, c.y})), band.first_row, last_row);
    const int left = clamped(std::floor(std::min({a.x, b.x, c.x})), 0, band.width - 1);
    const int right = clamped(std::ceil(std::max({a.x, b.x, c.x})), 0, band.width - 1);
    for (int row = top; row <= bottom; ++row) {
        for (int column = left; column <= right; ++column) {
            const auto [wa, wb, wc] = shares_at(scene, face, column + 0.5, row + 0.5);
            if (!(wa >= 0 && wb >= 0 && wc >= 0)) continue;
            const double depth = wa * a.depth + wb * b.depth + wc * c.depth;
            const auto place = at(row - band.first_row) * at(band.width) + at(column);
            if (depth <= band.depth[place]) continue;
            band.depth[place] = depth;
            band.face[place] = face;
        }
    }
}

/// Light on white paper: a soft key light from the upper left, fill from the right, sky from above,
/// and a little darkening where the surface turns away, which draws the outline.
double brightness(const Point& normal) {
    static const Point key = normalized({-0.45, 0.65, 0.75});
    static const Point fill = normalized({0.8, 0.1, 0.5});
    const double from_key = std::max(0.0, (dot(normal, key) + 0.15) / 1.15);
    const double from_fill = std::max(0.0, dot(normal, fill));
    const double from_sky = 0.5 + 0.5 * normal[1];
    const double facing = std::clamp(normal[2], 0.0, 1.0);
    const double light = 0.39 + 0.47 * from_key + 0.08 * from_fill + 0.12 * from_sky;
    return light * (0.66 + 0.34 * std::sqrt(facing));
}

Color shade(const Scene& scene, int face, double x, double y) {
    const std::array<double, 3> shares = shares_at(scene, face, x, y);
    Point normal{0, 0, 0};
    std::array<double, 3> color{0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
        const Corner& corner = scene.corner(face, k);
        for (std::size_t c = 0; c < 3; ++c) {
            normal[c] += shares[k] * corner.normal[c];
            color[c] += shares[k] * static_cast<double>(corner.color[c]);
        }
    }
    normal = normalized(normal);
    const Corner& a = scene.corner(face, 0);
    // Sample rows run downwards: a face turned to the viewer has a negative area there.
    const bool from_behind =
        twice_area(a, scene.corner(face, 1), scene.corner(face, 2).x, scene.corner(face, 2).y) > 0;
    if (from_behind) normal = {-normal[0], -normal[1], -normal[2]};
    const double light = brightness(normal);
    Color shaded;
    for (std::size_t c = 0; c < 3; ++c) {
        shaded[c] = static_cast<float>(std::clamp(color[c] * light, 0.0, 1.0));
    }
    return shaded;
}

void draw_band(const Scene& scene, const std::vector<int>& faces, int first_pixel_row,
               int pixel_rows, Image& image) {
    Band band{first_pixel_row * kSamples, pixel_rows * kSamples, scene.width, {}, {}};
    const auto size = at(band.rows) * at(band.width);
    band.depth.assign(size, -std::numeric_limits<double>::infinity());
    band.face.assign(size, kNothing);
    for (const int face : faces) draw_face(scene, face, band);
    for (int row = 0; row < pixel_rows; ++row) {
        for (int column = 0; column < image.width; ++column) {
            std::array<float, 3> sum{0, 0, 0};
            for (int sample = 0; sample < kSamples * kSamples; ++sample) {
                const int y = row * kSamples + sample / kSamples;
                const int x = column * kSamples + sample % kSamples;
                const int face = band.face[at(y * band.width + x)];
                const Color color = face == kNothing
                                        ? kBackground
                                        : shade(scene, face, x + 0.5, band.first_row + y + 0.5);
                for (std::size_t c = 0; c < 3; ++c) sum[c] += color[c];
            }
            const auto place = (at(first_pixel_row + row) * at(image.width) + at(column)) * 3;
            for (std::size_t c = 0; c < 3; ++c) {
                image.rgb[place + c] = static_cast<std::uint8_t>(
                    std::lround(255 * sum[c] / static_cast<float>(kSamples * kSamples)));
            }
        }
    }
}

/// The faces that may show in each band, in ascending order.
std::vector<std::vector<int>> faces_by_band(const Scene& scene, const Chunks& bands) {
    std::vector<std::vector<int>> faces(at(bands.count()));
    const double samples = static_cast<double>(bands.size) * kSamples;
    const auto last = static_cast<double>(bands.count() - 1);
    for (int face = 0; face < static_cast<int>(scene.faces->size()); ++face) {
        const auto [top, bottom] = std::minmax(
            {scene.corner(face, 0).y, scene.corner(face, 1).y, scene.corner(face, 2).y});
        if (bottom < 0 || top > scene.height) continue;
        const auto from =
            static_cast<std::size_t>(std::clamp(std::floor(top / samples), 0.0, last));
        const auto to =
            static_cast<std::size_t>(std::clamp(std::floor(bottom / samples), 0.0, last));
        for (std::size_t band = from; band <= to; ++band) faces[band].push_back(face);
    }
    return faces;
}

}  // namespace

Image render_mesh(const TriangleMesh& mesh, std::span<const Color> colors, const View& view,
                  int width, int height) {
    check_input(mesh, colors, width, height);
    const Scene scene = project(mesh, colors, view, width, height);
    Image image{width, height, std::vector<std::uint8_t>(at(width) * at(height) * 3)};
    const Chunks bands{height, kBandRows};
    const std::vector<std::vector<int>> faces = faces_by_band(scene, bands);
    parallel_for(bands.count(), [&](std::int64_t band) {
        const int first = static_cast<int>(bands.begin(band));
        draw_band(scene, faces[at(band)], first, static_cast<int>(bands.end(band)) - first, image);
    });
    return image;
}

Color white_to_blue(float amount) {
    const float t = amount > 0 ? std::min(amount, 1.0F) : 0.0F;
    constexpr Color blue{0.10F, 0.28F, 0.92F};
    return {1 - t * (1 - blue[0]), 1 - t * (1 - blue[1]), 1 - t * (1 - blue[2])};
}

}  // namespace mscomp
