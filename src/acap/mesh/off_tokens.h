// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "off_header.h"
#include "polygon_mesh.h"

namespace mscomp {

/// Reads what stands behind the header of an OFF file as one stream of numbers, whose lines may
/// break anywhere. Vertices have as many numbers as the header announces (colours four or three)
/// or, where all their lines are of one length, as these have. Behind the corners of a face stand
/// no numbers, or all to the end of the line (its colour), or 3, 4 or 1 behind every face. The
/// first of these readings that makes the promised counts of what there is, to the last number, is
/// taken; none if there is no such reading.
std::optional<PolygonMesh> read_off_tokens(TextCursor cursor, const OffHeader& header);

}  // namespace mscomp
