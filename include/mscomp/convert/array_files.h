// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "mscomp/convert/contents.h"

namespace mscomp {

/// Reads a .npz of numpy. With `features` (N,V,9) it is a feature set, the other arrays being named
/// as in the feature file and `names`, `weights`, `warnings` as text; whatever is missing but the
/// features comes from `supplement`. Otherwise it holds shapes: `vertices` or `verts` (N,V,3),
/// `faces` or `tris` (F,3), `names`. Other arrays are noted and left out. Throws IoError, or
/// InputError for archives and arrays that are not sound, of other types or shapes, numbers that
/// are not finite and faces out of range.
Contents read_npz(const std::string& path, const Supplement& supplement);

/// Reads a .npy, which holds features (N,V,9) or vertices (N,V,3). Throws as above.
Contents read_npy(const std::string& path, const Supplement& supplement);

/// Writes an uncompressed .npz as one atomic step: vertices [N,V,3] f64, faces [F,3] i32, names;
/// one shape in memory at a time. Throws IoError, or NumericalError if a position is not finite.
void write_npz(const std::string& path, const ShapeSource& shapes, const ShapesDone& done = {});
/// All of a feature set, under the names and with the types of the feature file.
void write_npz(const std::string& path, const FeatureSet& set, const VertexPlaces& places = {});

/// Writes a .npy of vertices [N,V,3] f64, or of features [N,V,9] f32. Throws as above.
void write_npy(const std::string& path, const ShapeSource& shapes, const ShapesDone& done = {});
void write_npy(const std::string& path, const FeatureSet& set);

}  // namespace mscomp
