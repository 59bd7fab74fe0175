// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>

#include "mscomp/convert/contents.h"

namespace mscomp {

/// Whether this build has HDF5. Without it the two functions throw UsageError saying so.
bool has_hdf5();

/// Opens an HDF5 file as SPLOCS has them: `verts` (N,V,3) of floating-point numbers and `tris`
/// (F,3) of integers; everything else in it is ignored. Shapes are read when asked for. For trusted
/// files only: HDF5's own reader is not hardened. Throws IoError, or InputError for files that are
/// no HDF5, missing or other data sets, and faces out of range.
Contents read_splocs(const std::string& path);

/// Writes `verts` f64 and `tris` i32, uncompressed, as one atomic step; one shape in memory at a
/// time, twice the disk space while writing. Throws IoError, or NumericalError if a position is not
/// finite.
void write_splocs(const std::string& path, const ShapeSource& shapes, const ShapesDone& done = {});

}  // namespace mscomp
