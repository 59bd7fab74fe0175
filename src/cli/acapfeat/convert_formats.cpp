// SPDX-License-Identifier: MIT
#include "convert_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "mscomp/base/error.h"
#include "mscomp/base/paths.h"

namespace mscomp {
namespace {

constexpr const char* kKnown =
    ".obj, .ply, .off, .safetensors, .npz, .npy, .h5, .hdf5 or LOGRNEW*.txt";

bool is_mesh_format(const std::string& name) {
    return name == "obj" || name == "ply" || name == "off";
}

std::optional<FileFormat> format_named(const std::string& name) {
    if (is_mesh_format(name)) return FileFormat::meshes;
    if (name == "safetensors") return FileFormat::safetensors;
    if (name == "npz") return FileFormat::npz;
    if (name == "npy") return FileFormat::npy;
    if (name == "h5" || name == "hdf5") return FileFormat::hdf5;
    if (name == "text" || name == "txt") return FileFormat::text;
    return std::nullopt;
}

bool is_exact_in(double x, const std::string& mesh_format) {
    if (static_cast<double>(static_cast<float>(x)) == x) return true;
    if (mesh_format == "ply") return false;
    return std::strtod(fmt::format("{:.9g}", x).c_str(), nullptr) == x;
}

}  // namespace

FileFormat input_format(const std::string& path) {
    if (is_folder(path)) return FileFormat::meshes;
    const std::optional<FileFormat> format = format_named(extension_of(path));
    if (!format || extension_of(path) == "text") {
        if (!path_exists(path)) {
            throw UsageError(fmt::format("there is no file or folder '{}'", path));
        }
        throw UsageError(
            fmt::format("{}: cannot tell the format; wanted a folder of meshes, {}", path, kKnown));
    }
    const std::string name = std::filesystem::path(path).filename().string();
    if (*format == FileFormat::text && !name.starts_with("LOGRNEW")) {
        throw UsageError(path + ": wanted the LOGRNEW*.txt of the pair; S*.txt is read beside it");
    }
    return *format;
}

Output output_format(const std::string& path, const std::string& to) {
    const std::string extension = extension_of(path);
    const bool names_folder = is_folder(path) || path.ends_with('/');
    const std::optional<FileFormat> own = format_named(extension);
    if (!to.empty()) {
        const FileFormat format = *format_named(to);
        const bool is_mesh = format == FileFormat::meshes;
        return {format, is_mesh && (names_folder || extension != to), is_mesh ? to : ""};
    }
    if (names_folder || extension.empty()) return {FileFormat::meshes, true, "obj"};
    if (!own || extension == "text") {
        throw UsageError(
            fmt::format("{}: cannot tell the format; wanted {}, a folder, or --to", path, kKnown));
    }
    return {*own, false, is_mesh_format(extension) ? extension : ""};
}

std::vector<std::string> extensions_of(const Output& output) {
    switch (output.format) {
        case FileFormat::meshes:
            return {output.mesh_format};
        case FileFormat::safetensors:
            return {"safetensors"};
        case FileFormat::npz:
            return {"npz"};
        case FileFormat::npy:
            return {"npy"};
        case FileFormat::hdf5:
            return {"h5", "hdf5"};
        case FileFormat::text:
            return {"txt"};
    }
    return {};
}

void Losses::add(const std::string& what) {
    if (std::find(all_.begin(), all_.end(), what) == all_.end()) all_.push_back(what);
}

void Losses::add_all_but_features(const PlacedFeatures& set) {
    for (const char* what : {"vertices", "reference", "faces", "motions", "names", "weights"}) {
        add(what);
    }
    if (!set.places.are_all_vertices()) add("places");
    if (!set.consistency_energy.empty()) add("consistency");
    if (!set.warnings.empty()) add("warnings");
}

void Losses::add_all_but_vertices(const PlacedFeatures& set) {
    for (const char* what : {"features", "reference", "motions", "weights"}) add(what);
    if (!set.places.are_all_vertices()) add("places");
    if (!set.consistency_energy.empty()) add("consistency");
    if (!set.warnings.empty()) add("warnings");
}

void Losses::watch_positions(const std::vector<Point>& positions, const std::string& mesh_format) {
    if (rounds_) return;
    for (const Point& position : positions) {
        for (const double x : position) rounds_ = rounds_ || !is_exact_in(x, mesh_format);
    }
    if (!rounds_) return;
    add(mesh_format == "ply" ? "digits beyond float32 of the positions"
                             : "digits beyond the ninth of the positions");
}

}  // namespace mscomp
