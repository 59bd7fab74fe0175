// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "mscomp/acap/placed_features.h"

namespace mscomp {

enum class FileFormat { meshes, safetensors, npz, npy, hdf5, text };

struct Output {
    FileFormat format = FileFormat::meshes;
    bool is_folder = false;
    std::string mesh_format;  // obj, ply or off
};

/// By the extension; folders and globs are meshes. Throws UsageError for others.
FileFormat input_format(const std::string& path);

/// `to` (obj, ply, off, safetensors, npz, npy, h5, text) decides where it is not empty, else the
/// extension of `path`; without any it is a folder of obj. Throws UsageError.
Output output_format(const std::string& path, const std::string& to);

/// What the name of such an output may end in, the usual extension first.
std::vector<std::string> extensions_of(const Output& output);

/// What a conversion does not carry over, every entry once.
class Losses {
  public:
    void add(const std::string& what);
    void add_all_but_features(const PlacedFeatures& set);
    void add_all_but_vertices(const PlacedFeatures& set);
    /// Adds a loss if these positions change when they are written as `mesh_format`.
    void watch_positions(const std::vector<Point>& positions, const std::string& mesh_format);
    const std::vector<std::string>& all() const { return all_; }

  private:
    std::vector<std::string> all_;
    bool rounds_ = false;
};

}  // namespace mscomp
