// SPDX-License-Identifier: MIT
#include "check_findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

namespace mscomp {

std::string counted(std::int64_t count, std::string_view one, std::string_view many) {
    return fmt::format("{} {}", count, count == 1 ? one : many);
}

std::vector<CheckedFile> checked_files(const std::vector<std::string>& paths) {
    std::vector<CheckedFile> files;
    std::set<std::string> labels;
    for (const std::string& path : paths) {
        files.push_back({path, std::filesystem::path(path).filename().string(), {}, {}});
        labels.insert(files.back().label);
    }
    if (labels.size() == files.size()) return files;
    for (CheckedFile& file : files) file.label = file.path;
    return files;
}

FindingBuilder::FindingBuilder(Severity severity, std::string kind) {
    finding_.severity = severity;
    finding_.kind = std::move(kind);
}

void FindingBuilder::add(CheckPlace place, std::int64_t count) {
    finding_.count += count;
    ++places_added_;
    if (finding_.places.size() < kPlacesKept) finding_.places.push_back(std::move(place));
}

void FindingBuilder::finish(std::string sentence, std::string advice,
                            std::vector<Finding>& findings) {
    if (finding_.count == 0) return;
    finding_.sentence = std::move(sentence);
    finding_.advice = std::move(advice);
    findings.push_back(std::move(finding_));
}

namespace {

struct RefusalKind {
    const char* kind;
    const char* one;
    const char* many;
    const char* advice;
};

constexpr std::array<RefusalKind, 4> kRefusals{{
    {"unreadable_file", "file cannot be opened or read", "files cannot be opened or read",
     "Check the path and the permissions."},
    {"malformed_file", "file is not a mesh that can be used",
     "files are not meshes that can be used",
     "Mend the line that is named, or export the file again."},
    {"other_vertex_count", "file has another number of vertices",
     "files have another number of vertices",
     "All shapes must be the same mesh, moved. Leave the file out, or bring it into "
     "correspondence first."},
    {"other_faces", "file has the right number of vertices but other faces",
     "files have the right number of vertices but other faces",
     "All shapes must have the same faces. Usually the file was exported with other settings "
     "(triangulated, reordered, remeshed): export it like the others."},
}};

/// The reference may be the one that is out of line: say so if most others agree with each other.
std::string hint_at_reference(const std::vector<CheckedFile>& files, const CheckReport& report) {
    std::map<int, int> shapes_with;
    for (const CheckedFile& file : files) {
        if (file.refusal && file.refusal->vertex_count > 0) {
            ++shapes_with[file.refusal->vertex_count];
        }
    }
    for (const auto& [vertices, shapes] : shapes_with) {
        if (2 * shapes <= report.files) continue;
        return fmt::format(
            " {} of {} files have {} vertices: perhaps it is the reference that is "
            "the odd one out; choose another with --reference.",
            shapes, report.files, vertices);
    }
    return "";
}

}  // namespace

void find_refusals(const std::vector<CheckedFile>& files, const CheckReport& report,
                   std::vector<Finding>& findings) {
    for (const RefusalKind& kind : kRefusals) {
        FindingBuilder builder(Severity::error, kind.kind);
        for (const CheckedFile& file : files) {
            if (!file.refusal || file.refusal->kind != kind.kind) continue;
            CheckPlace place{.text = file.refusal->message, .file = file.path};
            place.line = file.refusal->where.line;
            place.column = file.refusal->where.column;
            builder.add(std::move(place));
        }
        std::string advice = kind.advice;
        if (std::string_view(kind.kind) == "other_vertex_count") {
            advice += hint_at_reference(files, report);
        }
        builder.finish(counted(builder.count(), kind.one, kind.many), std::move(advice), findings);
    }
}

}  // namespace mscomp
