// SPDX-License-Identifier: MIT
#include "evaluation_files.h"

#include <fmt/format.h>

#include <cmath>

#include "mscomp/base/index.h"
#include "mscomp/base/json_text.h"
#include "mscomp/eval/measures.h"
#include "mscomp/render/error_sheet.h"

namespace mscomp {
namespace {

/// JSON has no numbers that are not finite and would say null, as for what is not there.
std::string number_cell(double value, const std::string& text) {
    return std::isfinite(value) ? text : fmt::format("{}", value);
}

std::string cell(const nlohmann::ordered_json& value) {
    if (value.is_null()) return {};
    if (value.is_number_float()) return number_cell(value.get<double>(), json_text(value));
    if (!value.is_string()) return json_text(value);
    auto text = value.get<std::string>();
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + '"';
}

void add_cells(const nlohmann::ordered_json& row, const std::string& prefix, std::string& names,
               std::string& values) {
    for (const auto& [key, value] : row.items()) {
        if (value.is_object()) {
            add_cells(value, prefix + key + "_", names, values);
            continue;
        }
        if (!names.empty()) {
            names += ',';
            values += ',';
        }
        names += prefix;
        names += key;
        values += cell(value);
    }
}

ComparedShape compared(const std::string& name, const char* fit, const std::vector<Point>& truth,
                       const DecodedShape& decoded, const std::vector<Point>& reference) {
    RmsError error(reference);
    error.add(truth, decoded.vertices);
    return {name, fmt::format("{} fit: E_rms {:.2f}", fit, error.value()), truth,
            aligned_to(truth, decoded.vertices), vertex_distances(truth, decoded.vertices)};
}

}  // namespace

std::string csv_of(const nlohmann::ordered_json& rows) {
    std::string result;
    for (const nlohmann::ordered_json& row : rows) {
        std::string names, values;
        add_cells(row, "", names, values);
        if (result.empty()) result = names + "\n";
        result += values + "\n";
    }
    return result;
}

void write_error_picture(const std::string& path, const std::string& title, ShapeDecoder& decoder,
                         const TrainedRun& run, const FeatureFile& file,
                         const std::vector<int>& shapes, std::span<const Fit> fits) {
    const TriangleMesh& reference = run.context().reference;
    const std::vector<DecodedShape> encoded = decoder.encode(shapes);
    std::vector<std::vector<DecodedShape>> results;
    for (const Fit fit : fits) results.push_back(fitted(fit, decoder, shapes, encoded));
    std::vector<ComparedShape> sheet;
    for (std::size_t m = 0; m < shapes.size(); ++m) {
        const std::string& name = file.outline().names[at(shapes[m])];
        const std::vector<Point> truth = decoder.truth(shapes[m]);
        for (std::size_t f = 0; f < fits.size(); ++f) {
            sheet.push_back(
                compared(name, name_of(fits[f]), truth, results[f][m], reference.vertices));
        }
    }
    write_png(path, error_sheet(reference, sheet, title, 340, 2));
}

}  // namespace mscomp
