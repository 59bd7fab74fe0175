// SPDX-License-Identifier: MIT
// Clean meshes of many kinds, each a function of its number, and their text in many spellings.
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "mscomp/base/random.h"
#include "shapes.h"

namespace mscomp {

using Polygons = std::vector<std::vector<int>>;

struct GeneratedMesh {
    std::vector<Point> vertices;
    Polygons faces;
};

/// Torus of `around` times `along` quads.
inline Polygons torus_quads(int around, int along) {
    Polygons quads;
    for (int i = 0; i < along; ++i) {
        for (int j = 0; j < around; ++j) {
            const int i2 = (i + 1) % along, j2 = (j + 1) % around;
            quads.push_back({i * around + j, i2 * around + j, i2 * around + j2, i * around + j2});
        }
    }
    return quads;
}

/// Draws in sequence.
class Draws {
  public:
    explicit Draws(std::uint64_t number) : random_(77, number) {}
    int below(int count) {
        return static_cast<int>(random_.bits(next_++) % static_cast<std::uint64_t>(count));
    }
    double between(double low, double high) {
        return low + (high - low) * random_.uniform(next_++);
    }
    double normal() { return random_.normal(next_++); }

  private:
    CounterRandom random_;
    std::uint64_t next_ = 0;
};

inline GeneratedMesh of_triangles(const TriangleMesh& mesh) {
    GeneratedMesh result{mesh.vertices, {}};
    for (const auto& [a, b, c] : mesh.faces) result.faces.push_back({a, b, c});
    return result;
}

/// A closed or open surface: sphere, capped or open cylinder, grid, torus of quads.
inline GeneratedMesh surface_of_kind(int kind, Draws& draws) {
    switch (kind) {
        case 0:
            return of_triangles(shapes::icosphere(draws.below(5)));
        case 1:
            return of_triangles(
                shapes::cylinder(3 + draws.below(40), 2 + draws.below(30), 1, 3, true));
        case 2:
            return of_triangles(
                shapes::cylinder(3 + draws.below(40), 2 + draws.below(30), 1, 3, false));
        case 3:
            return of_triangles(shapes::grid(2 + draws.below(40), 2 + draws.below(40)));
        default: {
            const int around = 3 + draws.below(20), along = 3 + draws.below(40);
            return {std::vector<Point>(static_cast<std::size_t>(around * along)),
                    torus_quads(around, along)};
        }
    }
}

/// Random affine map, size 10^-6 ... 10^6, and noise in every digit.
inline GeneratedMesh generated_mesh(int number) {
    Draws draws(static_cast<std::uint64_t>(number));
    GeneratedMesh mesh = surface_of_kind(number % 5, draws);
    std::array<double, 9> map;
    for (double& entry : map) entry = draws.normal();
    const double size = std::pow(10.0, draws.between(-6, 6)), noise = draws.between(0.01, 0.5);
    const Point shift{draws.normal(), draws.normal(), draws.normal()};
    for (Point& p : mesh.vertices) {
        const Point q{p[0] + noise * draws.normal(), p[1] + noise * draws.normal(),
                      p[2] + noise * draws.normal()};
        for (std::size_t i = 0; i < 3; ++i) {
            p[i] = size *
                   (map[3 * i] * q[0] + map[3 * i + 1] * q[1] + map[3 * i + 2] * q[2] + shift[i]);
        }
    }
    return mesh;
}

/// One of five spellings: shortest, scientific, plain with few decimals, 9 and 17 digits.
inline std::string number_text(double value, int spelling) {
    char text[512];
    char* const end = text + sizeof(text);
    switch (spelling) {
        case 0:
            return {text, std::to_chars(text, end, value).ptr};
        case 1:
            return {text, std::to_chars(text, end, value, std::chars_format::scientific).ptr};
        case 2:
            return {text, std::to_chars(text, end, value, std::chars_format::fixed, 6).ptr};
        case 3:
            return {text, std::to_chars(text, end, value, std::chars_format::general, 9).ptr};
        default:
            return {text, std::to_chars(text, end, value, std::chars_format::general, 17).ptr};
    }
}

inline std::string point_text(const Point& p, int spelling) {
    return number_text(p[0], spelling) + " " + number_text(p[1], spelling) + " " +
           number_text(p[2], spelling) + "\n";
}

enum class Corner { plain, texture, normal, texture_and_normal, negative };

inline std::string obj_text(const GeneratedMesh& mesh, int spelling, Corner corner) {
    std::string text = "# generated\n";
    for (const Point& p : mesh.vertices) text += "v " + point_text(p, spelling);
    text += "vt 0.25 0.75\nvn 0 0 1\n";
    for (const std::vector<int>& face : mesh.faces) {
        text += "f";
        for (const int v : face) {
            const std::string index = std::to_string(v + 1);
            switch (corner) {
                case Corner::plain:
                    text += " " + index;
                    break;
                case Corner::texture:
                    text += " " + index + "/1";
                    break;
                case Corner::normal:
                    text += " " + index + "//1";
                    break;
                case Corner::texture_and_normal:
                    text += " " + index + "/1/1";
                    break;
                case Corner::negative:
                    text += " " + std::to_string(v - static_cast<int>(mesh.vertices.size()));
                    break;
            }
        }
        text += "\n";
    }
    return text;
}

inline std::string rows_text(const GeneratedMesh& mesh, int spelling) {
    std::string text;
    for (const Point& p : mesh.vertices) text += point_text(p, spelling);
    for (const std::vector<int>& face : mesh.faces) {
        text += std::to_string(face.size());
        for (const int v : face) text += " " + std::to_string(v);
        text += "\n";
    }
    return text;
}

inline std::string off_text(const GeneratedMesh& mesh, int spelling) {
    return "OFF\n" + std::to_string(mesh.vertices.size()) + " " +
           std::to_string(mesh.faces.size()) + " 0\n" + rows_text(mesh, spelling);
}

inline std::string ply_header(const GeneratedMesh& mesh, const std::string& format) {
    return "ply\nformat " + format + " 1.0\nelement vertex " +
           std::to_string(mesh.vertices.size()) +
           "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
           std::to_string(mesh.faces.size()) +
           "\nproperty list uchar int vertex_indices\nend_header\n";
}

inline std::string ply_text(const GeneratedMesh& mesh, int spelling) {
    return ply_header(mesh, "ascii") + rows_text(mesh, spelling);
}

template <class T>
void append_bytes(std::string& bytes, T value, bool big) {
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), &value, sizeof(T));
    if (big) std::reverse(raw.begin(), raw.end());
    bytes.append(raw.data(), raw.size());
}

/// With coordinates as doubles.
inline std::string ply_bytes(const GeneratedMesh& mesh, bool big) {
    std::string bytes = ply_header(mesh, big ? "binary_big_endian" : "binary_little_endian");
    for (const Point& p : mesh.vertices) {
        for (const double x : p) append_bytes(bytes, x, big);
    }
    for (const std::vector<int>& face : mesh.faces) {
        append_bytes(bytes, static_cast<std::uint8_t>(face.size()), big);
        for (const int v : face) append_bytes(bytes, v, big);
    }
    return bytes;
}

}  // namespace mscomp
