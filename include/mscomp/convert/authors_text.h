// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "mscomp/base/feature_set.h"

namespace mscomp {

/// The two text files of the ACAP authors' program: one line per shape, on it for every vertex a
/// full 3x3 matrix row by row, separated by blanks.
enum class AuthorsMatrix {
    log_rotation,  // LOGRNEW: the skew matrix of r, so m21 m02 m10 are r_x r_y r_z
    stretch        // S: symmetric
};

/// One such file: (N,V,3) of r or (N,V,6) of S11 S12 S13 S22 S23 S33.
struct AuthorsText {
    int shape_count = 0, vertex_count = 0;
    std::vector<float> channels;
};

/// Reads one file; the two entries that mirror each other are averaged. Accepts CR LF and a byte
/// order mark. `path` is only used in messages. Throws InputError with line and column for what is
/// no finite number, lines of another length, counts that are no multiple of 9, and matrices that
/// are not skew or not symmetric to 1e-4 (of an entry, or absolute below 1).
AuthorsText parse_authors_text(std::string_view text, AuthorsMatrix kind, const std::string& path);

/// features (N,V,9) of both. Throws InputError naming `stretch_path` if the counts differ.
std::vector<float> join_authors_text(const AuthorsText& log_rotation, const AuthorsText& stretch,
                                     const std::string& stretch_path);

/// Writes one of the two, 9 significant digits so that float32 survives, as one atomic step. Throws
/// IoError, or NumericalError if a feature is not finite.
void write_authors_text(const std::string& path, const FeatureSet& set, AuthorsMatrix kind);

/// The S file that belongs to a LOGRNEW file: "x/LOGRNEW_a.txt" -> "x/S_a.txt"; empty if the name
/// of `path` does not begin with LOGRNEW.
std::string stretch_path_of(const std::string& path);

}  // namespace mscomp
