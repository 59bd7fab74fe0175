// SPDX-License-Identifier: MIT
#include "convert_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

constexpr const char* kKnown =
    ".obj, .ply, .off, .safetensors, .npz, .npy, .h5, .hdf5 or LOGRNEW*.txt";

/// Lower case, without its dot.
std::string extension_of(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    if (!extension.empty()) extension.erase(0, 1);
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

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
    if (std::filesystem::is_directory(path)) return FileFormat::meshes;
    const std::optional<FileFormat> format = format_named(extension_of(path));
    if (!format || extension_of(path) == "text") {
        if (!std::filesystem::exists(path)) {
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
    const bool is_folder = std::filesystem::is_directory(path) || path.ends_with('/');
    const std::optional<FileFormat> own = format_named(extension);
    if (!to.empty()) {
        const FileFormat format = *format_named(to);
        const bool is_mesh = format == FileFormat::meshes;
        return {format, is_mesh && (is_folder || extension != to), is_mesh ? to : ""};
    }
    if (is_folder || extension.empty()) return {FileFormat::meshes, true, "obj"};
    if (!own || extension == "text") {
        throw UsageError(
            fmt::format("{}: cannot tell the format; wanted {}, a folder, or --to", path, kKnown));
    }
    return {*own, false, is_mesh_format(extension) ? extension : ""};
}

void Losses::add(const std::string& what) {
    if (std::find(all_.begin(), all_.end(), what) == all_.end()) all_.push_back(what);
}

void Losses::add_all_but_features(const FeatureSet& set) {
    for (const char* what : {"vertices", "reference", "faces", "motions", "names", "weights"}) {
        add(what);
    }
    if (!set.consistency_energy.empty()) add("consistency");
    if (!set.warnings.empty()) add("warnings");
}

void Losses::add_all_but_vertices(const FeatureSet& set) {
    for (const char* what : {"features", "reference", "motions", "weights"}) add(what);
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
