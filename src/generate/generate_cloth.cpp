// SPDX-License-Identifier: MIT
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "angles.h"
#include "generate_motion.h"
#include "limb.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/generate/generate.h"

namespace mscomp {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kHalfWidth = 7, kHalfHeight = 4.5;

/// 1 at 0, smoothly to 0 at 1 and beyond.
double window(double x) { return std::abs(x) < 1 ? std::pow(std::cos(kPi / 2 * x), 2) : 0; }

// ---------------------------------------------------------------------------------------------
// What moves.

/// Adds to the slope of the sheet's horizontal profile, by up to `degrees`.
struct Fold {
    const char* name;
    double degrees;
    double (*slope)(double u);    // in [-1, 1], at rest width u
    double (*support)(double u);  // share of the rotation, in [0, 1]
};

constexpr double kFolded = 2.8;   // |u| < kFolded carries the folds,
constexpr double kArcEnds = 4.4;  // kFolded..kArcEnds the arcs of the sides
double fold_window(double u) { return window(u / kFolded); }

const std::vector<Fold>& folds() {
    static const std::vector<Fold> all{
        {"left_side", 75, [](double u) { return -smooth_step(-u, kFolded, kArcEnds); },
         [](double u) { return smooth_step(-u, kFolded, kArcEnds); }},
        {"right_side", 75, [](double u) { return smooth_step(u, kFolded, kArcEnds); },
         [](double u) { return smooth_step(u, kFolded, kArcEnds); }},
        // A quarter of a wave apart: together they make a fold that travels to and fro.
        {"fold_ridge", 60,
         [](double u) { return -fold_window(u) * std::sin(2 * kPi * u / kFolded); }, fold_window},
        {"fold_step", 60, [](double u) { return fold_window(u) * std::cos(2 * kPi * u / kFolded); },
         fold_window}};
    return all;
}

/// Curls a corner up about a line across it.
struct Corner {
    const char* name;
    double horizontal, vertical;  // -1 or 1: which corner

    /// Distance beyond the line, along the way to the corner.
    double beyond(double u, double v) const {
        constexpr double reach = 1.83;  // of the corner
        return (horizontal * u + vertical * v - kHalfWidth - kHalfHeight) / std::sqrt(2.0) + reach;
    }
    static double share(double beyond) { return smooth_step(beyond, 0, 1.7); }
};
constexpr double kCornerDegrees = 125;

const std::vector<Corner>& corners() {
    static const std::vector<Corner> all{{"corner_top_left", -1, 1},
                                         {"corner_top_right", 1, 1},
                                         {"corner_bottom_left", -1, -1},
                                         {"corner_bottom_right", 1, -1}};
    return all;
}

/// A patch of waves along the normal.
struct Wrinkle {
    const char* name;
    double u, v;                     // middle
    double half_length, half_width;  // along and across the waves
    double degrees;                  // direction of the waves, 0: along u
    double height, wave_length;

    Vector2d local(double at_u, double at_v) const {
        const double c = std::cos(radians(degrees)), s = std::sin(radians(degrees));
        return {c * (at_u - u) + s * (at_v - v), -s * (at_u - u) + c * (at_v - v)};
    }
    double support(double at_u, double at_v) const {
        const Vector2d x = local(at_u, at_v);
        return window(std::hypot(x[0] / half_length, x[1] / half_width));
    }
    double wave(double at_u, double at_v) const {
        return std::cos(2 * kPi * local(at_u, at_v)[0] / wave_length);
    }
};

const std::vector<Wrinkle>& wrinkles() {
    static const std::vector<Wrinkle> all{
        {"wrinkles_left", -4.8, 0.5, 2.1, 1.7, 60, 0.05, 1.0},
        {"wrinkles_right", 4.7, -0.6, 2.1, 1.7, 120, 0.05, 1.0},
        {"wrinkles_top", -1.2, 2.7, 1.7, 1.9, 75, 0.05, 1.0},
        {"wrinkles_middle", 0.6, 0.2, 1.9, 1.6, 50, 0.05, 1.1},
        {"wrinkles_bottom", -0.8, -2.5, 1.8, 1.8, 100, 0.05, 1.0},
        {"wrinkles_crossing", 2.1, -1.6, 1.8, 1.4, 135, 0.045, 0.95}};
    return all;
}

// ---------------------------------------------------------------------------------------------
// The sheet at rest: the plane z = 0, seen from +z.

TriangleMesh sheet_with_vertices(int vertices) {
    const int columns = static_cast<int>(std::ceil(std::sqrt(vertices * kHalfWidth / kHalfHeight)));
    const int rows = (vertices + columns - 1) / columns;
    TriangleMesh mesh;
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            mesh.vertices.push_back({kHalfWidth * (2.0 * column / (columns - 1) - 1),
                                     kHalfHeight * (2.0 * row / (rows - 1) - 1), 0});
        }
    }
    for (int row = 0; row + 1 < rows; ++row) {
        for (int column = 0; column + 1 < columns; ++column) {
            const int a = row * columns + column, b = a + 1, c = a + columns, d = c + 1;
            // Diagonals in turn, so that no direction is preferred.
            if ((row + column) % 2 == 0) {
                mesh.faces.insert(mesh.faces.end(), {Face{a, b, d}, Face{a, d, c}});
            } else {
                mesh.faces.insert(mesh.faces.end(), {Face{a, b, c}, Face{b, d, c}});
            }
        }
    }
    return mesh;
}

// ---------------------------------------------------------------------------------------------
// Bending without stretching: a line of given slope, at its own length.

/// A plane curve through the origin at s = 0 whose direction at s is `slope(s)`, in radians.
class BentLine {
  public:
    template <class Slope>
    BentLine(double from, double to, const Slope& slope) : first_(std::lround(from / kStep)) {
        const auto last = std::lround(to / kStep);
        Vector2d point(0, 0);
        for (auto i = first_; i <= last; ++i) {
            points_.push_back(point);
            slopes_.push_back(slope((static_cast<double>(i) + 0.5) * kStep));
            point += kStep * direction(slopes_.back());
        }
        const Vector2d origin = points_[at(-first_)];
        for (Vector2d& each : points_) each -= origin;
    }

    Vector2d point(double s) const {
        const std::size_t i = index(s);
        const double rest = s - kStep * static_cast<double>(first_ + static_cast<long>(i));
        return points_[i] + rest * direction(slopes_[i]);
    }

  private:
    static constexpr double kStep = 1.0 / 1024;
    static Vector2d direction(double slope) { return {std::cos(slope), std::sin(slope)}; }
    std::size_t index(double s) const {
        const long i = static_cast<long>(std::floor(s / kStep)) - first_;
        return at(std::clamp(i, 0L, static_cast<long>(points_.size()) - 1));
    }

    long first_;
    std::vector<Vector2d> points_;
    std::vector<double> slopes_;
};

/// The curled corners and the wrinkles: where a point of the sheet goes in (u, v, height).
class Relief {
  public:
    explicit Relief(const float* corner_weights) : wrinkle_weights_(corner_weights + 4) {
        for (std::size_t c = 0; c < corners().size(); ++c) {
            const double curl = radians(kCornerDegrees) * static_cast<double>(corner_weights[c]);
            curls_.emplace_back(0.0, 3.0,
                                [curl](double beyond) { return curl * Corner::share(beyond); });
        }
    }

    Vector3d operator()(double u, double v) const {
        Vector3d place(u, v, 0);
        for (std::size_t c = 0; c < corners().size(); ++c) {
            const Corner& corner = corners()[c];
            const double beyond = corner.beyond(u, v);
            if (beyond <= 0) continue;
            const Vector2d bent = curls_[c].point(beyond);
            const double inwards = (bent[0] - beyond) / std::sqrt(2.0);
            place += Vector3d(corner.horizontal * inwards, corner.vertical * inwards, bent[1]);
        }
        for (std::size_t w = 0; w < wrinkles().size(); ++w) {
            const Wrinkle& wrinkle = wrinkles()[w];
            place[2] += static_cast<double>(wrinkle_weights_[w]) * wrinkle.height *
                        wrinkle.support(u, v) * wrinkle.wave(u, v);
        }
        return place;
    }

  private:
    const float* wrinkle_weights_;
    std::vector<BentLine> curls_;
};

std::vector<Point> pose(const TriangleMesh& sheet, const float* weights) {
    const auto slope = [weights](double u) {
        double sum = 0;
        for (std::size_t f = 0; f < folds().size(); ++f) {
            sum +=
                static_cast<double>(weights[f]) * radians(folds()[f].degrees) * folds()[f].slope(u);
        }
        return sum;
    };
    const BentLine profile(-kHalfWidth - 1, kHalfWidth + 1, slope);
    const Relief relief(weights + folds().size());
    std::vector<Point> points;
    for (const Point& rest : sheet.vertices) {
        const Vector3d place = relief(rest[0], rest[1]);
        const Vector2d line = profile.point(place[0]);
        const double direction = slope(place[0]);
        points.push_back({line[0] - place[2] * std::sin(direction), place[1],
                          line[1] + place[2] * std::cos(direction)});
    }
    return points;
}

std::vector<Mover> cloth_movers() {
    std::vector<Mover> all;
    for (const Fold& fold : folds()) all.push_back({fold.name, 0, -1});
    for (const Corner& corner : corners()) all.push_back({corner.name, 0, 0});
    for (const Wrinkle& wrinkle : wrinkles()) all.push_back({wrinkle.name, 1, -1});
    return all;
}

/// (V) how much each component reaches (u, v), in the order of cloth_movers().
std::vector<double> supports_at(double u, double v) {
    std::vector<double> all;
    for (const Fold& fold : folds()) all.push_back(fold.support(u));
    for (const Corner& corner : corners()) all.push_back(Corner::share(corner.beyond(u, v)));
    for (const Wrinkle& wrinkle : wrinkles()) all.push_back(wrinkle.support(u, v));
    return all;
}

}  // namespace

GeneratedSequence generate_cloth(int frames, std::uint64_t seed, int vertices) {
    require_size("cloth", frames, vertices);
    const TriangleMesh sheet = sheet_with_vertices(vertices);
    GeneratedSequence result = still_sequence(cloth_movers(), frames, seed);
    const std::size_t count = result.component_names.size();
    result.sequence.faces = sheet.faces;
    result.supports.resize(count * sheet.vertices.size());
    for (std::size_t i = 0; i < sheet.vertices.size(); ++i) {
        const std::vector<double> here = supports_at(sheet.vertices[i][0], sheet.vertices[i][1]);
        for (std::size_t k = 0; k < count; ++k) {
            result.supports[k * sheet.vertices.size() + i] = static_cast<float>(here[k]);
        }
    }
    result.sequence.shapes[0] = sheet.vertices;
    parallel_for(frames - 1, [&](std::int64_t n) {
        const auto place = at(n) + 1;
        result.sequence.shapes[place] = pose(sheet, result.weights.data() + place * count);
    });
    return result;
}

}  // namespace mscomp
