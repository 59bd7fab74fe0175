// SPDX-License-Identifier: MIT
#include "obj_statements.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "mscomp/base/file_kind.h"
#include "mscomp/base/index.h"
#include "number_text.h"

namespace mscomp {
namespace {

/// Statements that change no vertex and no face, and what is not kept of them; nothing where they
/// only say how to draw. Not among them: "call" and "csh", which would bring in other files.
struct Statement {
    std::string_view keyword, unused;
};
constexpr std::string_view kCurves = "curves and surfaces";
constexpr std::array<Statement, 35> kSkippedStatements{{{"vt", "texture coordinates"},
                                                        {"vn", "normals"},
                                                        {"usemtl", "materials"},
                                                        {"mtllib", "materials"},
                                                        {"g", "groups"},
                                                        {"o", "groups"},
                                                        {"s", ""},
                                                        {"l", "lines"},
                                                        {"p", "points"},
                                                        {"vp", kCurves},
                                                        {"mg", ""},
                                                        {"usemap", "materials"},
                                                        {"maplib", "materials"},
                                                        {"lod", ""},
                                                        {"bevel", ""},
                                                        {"shadow_obj", ""},
                                                        {"trace_obj", ""},
                                                        {"cstype", kCurves},
                                                        {"deg", kCurves},
                                                        {"bmat", kCurves},
                                                        {"step", kCurves},
                                                        {"curv", kCurves},
                                                        {"curv2", kCurves},
                                                        {"surf", kCurves},
                                                        {"parm", kCurves},
                                                        {"trim", kCurves},
                                                        {"hole", kCurves},
                                                        {"scrv", kCurves},
                                                        {"sp", kCurves},
                                                        {"end", kCurves},
                                                        {"con", kCurves},
                                                        {"ctech", ""},
                                                        {"stech", ""},
                                                        {"c_interp", ""},
                                                        {"d_interp", ""}}};

/// Printable ASCII that does not begin as a number does, nor as "v" or "f" and a number.
bool is_name(std::string_view keyword) {
    constexpr std::string_view numeric = "0123456789+-.";
    const std::string_view letters = "vVfF";
    const bool is_glued = keyword.size() > 1 && letters.find(keyword[0]) != letters.npos &&
                          numeric.find(keyword[1]) != numeric.npos;
    return !is_glued && numeric.find(keyword.front()) == numeric.npos &&
           std::all_of(keyword.begin(), keyword.end(), [](char c) { return c > 0x20 && c < 0x7f; });
}

}  // namespace

ObjStatements::ObjStatements() : is_met_(kSkippedStatements.size(), 0) {}

bool ObjStatements::note_known(std::string_view keyword) {
    const auto known = std::find_if(kSkippedStatements.begin(), kSkippedStatements.end(),
                                    [&](const auto& s) { return s.keyword == keyword; });
    if (known == kSkippedStatements.end()) return false;
    is_met_[at(known - kSkippedStatements.begin())] = 1;
    return true;
}

std::vector<std::string_view> ObjStatements::unused() const {
    std::vector<std::string_view> names;
    for (std::size_t i = 0; i < kSkippedStatements.size(); ++i) {
        const std::string_view unused = kSkippedStatements[i].unused;
        if (is_met_[i] != 0 && !unused.empty()) names.push_back(unused);
    }
    return names;
}

bool ObjStatements::may_be_foreign(std::string_view keyword) {
    constexpr std::array<std::string_view, 5> refused{"V", "F", "FO", "call", "csh"};
    const bool is_refused = std::find(refused.begin(), refused.end(), keyword) != refused.end();
    return !is_refused && is_name(keyword);
}

std::string ObjStatements::complaint_about(std::string_view keyword) {
    if (keyword.starts_with(kByteOrderMark)) {
        return fmt::format(
            "got a byte order mark (BOM) before {}, expected it at the start of "
            "the file only; were files put together?",
            in_quotes(keyword.substr(kByteOrderMark.size())));
    }
    return fmt::format(
        "got the keyword {}, expected v, f, vt, vn, g, o, s, usemtl or another "
        "one of OBJ",
        in_quotes(keyword));
}

}  // namespace mscomp
