// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Reads an OBJ, PLY or OFF file, chosen by its extension. Vertices keep their number and order:
/// nothing is merged, dropped or duplicated. Polygons are split along inner diagonals, which do not
/// depend on the corner they begin with. Accepts what is harmless (BOM, CRLF, padding at the end,
/// continuation lines, v/vt/vn, negative indices, extra numbers); faces of fewer than three corners
/// and unknown statements are left out. Throws IoError (cannot be read) or InputError with file,
/// line, column, got and wanted (NaN or infinite coordinates, decimal commas, indices out of range,
/// truncated lines, ...).
TriangleMesh read_mesh(const std::string& path);

/// The same from text in memory; `path` is only used in messages.
TriangleMesh parse_obj(std::string_view text, const std::string& path);
TriangleMesh parse_ply(std::string_view bytes, const std::string& path);
TriangleMesh parse_off(std::string_view text, const std::string& path);

/// Writes an OBJ (9 significant digits, so float32 positions survive; one more for every factor of
/// ten that the surface lies further than its size from the origin) as one atomic step. Throws
/// NumericalError if a position is not finite, IoError if it cannot be written.
void write_obj(const std::string& path, const TriangleMesh& mesh);

/// Likewise an OFF in text form.
void write_off(const std::string& path, const TriangleMesh& mesh);

struct VertexColor {
    std::uint8_t red = 255, green = 255, blue = 255;
};

/// Writes a binary little-endian PLY as one atomic step: float x y z (double where the surface lies
/// so far from the origin that floats would spoil it), and where given uchar red
/// green blue (V) and float quality (V). Throws as write_obj does, NumericalError also for a
/// position beyond float32.
void write_ply(const std::string& path, const TriangleMesh& mesh,
               std::span<const VertexColor> colors = {}, std::span<const float> quality = {});

/// Writes an OBJ, PLY or OFF file, chosen by the extension; UsageError for another extension.
void write_mesh(const std::string& path, const TriangleMesh& mesh);

/// The positions that who reads the file finds that write_mesh(path, mesh) writes.
std::vector<Point> as_written(const std::string& path, const TriangleMesh& mesh);

}  // namespace mscomp
