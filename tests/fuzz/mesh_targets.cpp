// SPDX-License-Identifier: MIT
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "acap/mesh/number_text.h"
#include "base/temporary_folder.h"
#include "fuzz/promises.h"
#include "fuzz/targets.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/base/atomic_file.h"

namespace mscomp::fuzz {
namespace {

const std::string kPath = "input";

void check_sound(const TriangleMesh& mesh) {
    require(!mesh.vertices.empty() && !mesh.faces.empty(), "a mesh has vertices and faces");
    for (const Point& point : mesh.vertices) {
        for (const double x : point) require(std::isfinite(x), "coordinates are finite");
    }
    for (const Face& face : mesh.faces) {
        for (const int corner : face) {
            require(corner >= 0 && corner < mesh.vertex_count(), "faces refer to vertices");
        }
    }
}

/// Within float32, where infinity lies beyond.
double as_float(double x) { return static_cast<double>(static_cast<float>(x)); }

/// Whether `read` is `written` with nine significant digits.
bool survives_nine_digits(double written, double read) {
    if (as_float(written) == written && as_float(read) != written) return false;
    return std::signbit(written) == std::signbit(read) &&
           std::abs(read - written) <= 5.000001e-9 * std::abs(written);
}

bool same_mesh(const TriangleMesh& a, const TriangleMesh& b) {
    return same_bits(a.vertices, b.vertices) && a.faces == b.faces;
}

using Parse = TriangleMesh (*)(std::string_view, const std::string&);
using Write = void (*)(const std::string&, const TriangleMesh&);

void check_round_trip_of_text(const TriangleMesh& mesh, Write write, Parse parse) {
    static const TemporaryFolder folder;
    const std::string path = folder / "mesh";
    write(path, mesh);
    const std::string text = read_file(path);
    const TriangleMesh again = parse(text, path);
    require(again.faces == mesh.faces, "faces survive writing and reading");
    require(again.vertex_count() == mesh.vertex_count(), "all vertices survive");
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            require(survives_nine_digits(mesh.vertices[i][axis], again.vertices[i][axis]),
                    "coordinates survive with nine digits");
        }
    }
    write(path, again);
    require(read_file(path) == text, "written again it is the same file");
}

/// The same with a blank at the end of every line, which must not matter.
void check_blanks_at_line_ends(std::string_view text, const std::optional<TriangleMesh>& mesh,
                               Parse parse) {
    std::string variant;
    for (const char c : text) {
        if (c == '\n') variant += ' ';
        variant += c;
    }
    const auto again = unless_refused(kPath, [&] { return parse(variant, kPath); });
    require(again.has_value() == mesh.has_value() && (!again || same_mesh(*again, *mesh)),
            "a blank at the end of a line changes nothing");
}

/// Every number of the text is what the C library takes it for.
void check_numbers(std::string_view text) {
    constexpr std::string_view kSeparators = " \t\r\n";
    for (std::size_t at = text.find_first_not_of(kSeparators); at != std::string_view::npos;) {
        const std::size_t end = std::min(text.find_first_of(kSeparators, at), text.size());
        const std::string token(text.substr(at, end - at));
        const NumberText number = read_number(token.data(), token.data() + token.size());
        if (number.kind == NumberText::Kind::finite) {
            const std::string used(token.data(), number.end);
            char* after = nullptr;
            const double wanted = std::strtod(used.c_str(), &after);
            require(*after == '\0' && std::bit_cast<std::uint64_t>(wanted) ==
                                          std::bit_cast<std::uint64_t>(number.value),
                    "numbers are read exactly");
        }
        at = text.find_first_not_of(kSeparators, end);
    }
}

/// OpenMesh holds whatever faces there are.
void check_connectivity(const TriangleMesh& mesh) {
    const SurfaceConnectivity surface = analyze_connectivity(mesh.vertex_count(), mesh.faces);
    const OneRings wanted = one_rings_of_faces(mesh.vertex_count(), mesh.faces);
    require(surface.rings.offsets == wanted.offsets && surface.rings.neighbors == wanted.neighbors,
            "one-rings are those of the faces");
}

}  // namespace

void check_obj(std::span<const std::byte> input) {
    const std::string_view text = text_of(input);
    const auto mesh = unless_refused(kPath, [&] { return parse_obj(text, kPath); });
    // A blank behind a backslash ends the continuation.
    if (text.find('\\') == text.npos) check_blanks_at_line_ends(text, mesh, parse_obj);
    if (!mesh) return;
    check_sound(*mesh);
    check_round_trip_of_text(*mesh, write_obj, parse_obj);
    check_connectivity(*mesh);
}

void check_off(std::span<const std::byte> input) {
    const std::string_view text = text_of(input);
    check_numbers(text);
    const auto mesh = unless_refused(kPath, [&] { return parse_off(text, kPath); });
    check_blanks_at_line_ends(text, mesh, parse_off);
    if (!mesh) return;
    check_sound(*mesh);
    check_round_trip_of_text(*mesh, write_off, parse_off);
}

void check_ply(std::span<const std::byte> input) {
    const auto mesh = unless_refused(kPath, [&] { return parse_ply(text_of(input), kPath); });
    if (!mesh) return;
    check_sound(*mesh);
    TriangleMesh wanted = *mesh;
    bool fits = true;
    for (Point& point : wanted.vertices) {
        for (double& x : point) {
            x = as_float(x);
            fits = fits && std::isfinite(x);
        }
    }
    static const TemporaryFolder folder;
    const std::string path = folder / "mesh.ply";
    try {
        write_ply(path, *mesh);
    } catch (const NumericalError&) {
        require(!fits, "what fits float32 is written");
        return;
    }
    require(same_mesh(parse_ply(read_file(path), path), wanted),
            "the mesh survives in float32, bit for bit");
}

}  // namespace mscomp::fuzz
