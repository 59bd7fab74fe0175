// SPDX-License-Identifier: MIT
#include "mscomp/convert/authors_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>

#include "acap/mesh/text_cursor.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

constexpr std::size_t kEntries = 9;
constexpr double kTolerance = 1e-4;
constexpr std::string_view kStem = "LOGRNEW";

/// Which entries of the matrix, row by row, a channel is; `mirror` holds the same number, with the
/// opposite sign in a skew matrix.
struct Channel {
    std::size_t entry, mirror;
};
constexpr std::array<Channel, 3> kSkew{{{7, 5}, {2, 6}, {3, 1}}};
constexpr std::array<Channel, 6> kSymmetric{{{0, 0}, {1, 3}, {2, 6}, {4, 4}, {5, 7}, {8, 8}}};
constexpr std::array<std::size_t, 3> kDiagonal{0, 4, 8};

using Matrix = std::array<double, kEntries>;

class Reader {
  public:
    Reader(std::string_view text, AuthorsMatrix kind, const std::string& path)
        : cursor_(text, text_begin(text, path, "a text of matrices"), 1, path),
          kind_(kind),
          path_(path) {}

    AuthorsText read() {
        skip_to_text();
        while (!cursor_.at_end()) {
            read_line();
            ++result_.shape_count;
            skip_to_text();
        }
        if (result_.shape_count == 0) {
            throw InputError({path_}, "has no numbers, expected one line for every shape");
        }
        return std::move(result_);
    }

  private:
    /// Over lines without anything in them.
    void skip_to_text() {
        for (;;) {
            cursor_.skip_blanks();
            if (cursor_.at_end() || !cursor_.at_line_end()) return;
            cursor_.next_line();
        }
    }

    void read_line() {
        const std::int64_t wanted =
            result_.shape_count == 0 ? std::numeric_limits<int>::max() : result_.vertex_count;
        std::int64_t vertex = 0;
        for (cursor_.skip_blanks(); !cursor_.at_line_end(); cursor_.skip_blanks()) {
            if (vertex == wanted) {
                cursor_.fail(
                    fmt::format("the line has more than {} numbers, expected as many as in "
                                "the lines before it",
                                wanted * static_cast<std::int64_t>(kEntries)));
            }
            read_matrix(vertex++);
        }
        if (result_.shape_count == 0) result_.vertex_count = static_cast<int>(vertex);
        if (vertex != result_.vertex_count) {
            cursor_.fail(
                fmt::format("the line has {} numbers, expected {} as in the lines before "
                            "it",
                            vertex * static_cast<std::int64_t>(kEntries),
                            result_.vertex_count * static_cast<std::int64_t>(kEntries)));
        }
        if (!cursor_.at_end()) cursor_.next_line();
    }

    void read_matrix(std::int64_t vertex) {
        Matrix matrix{};
        for (std::size_t i = 0; i < kEntries; ++i) {
            cursor_.skip_blanks();
            if (cursor_.at_line_end()) {
                cursor_.fail(fmt::format(
                    "the line has {} numbers, expected a multiple of 9",
                    vertex * static_cast<std::int64_t>(kEntries) + static_cast<std::int64_t>(i)));
            }
            matrix[i] = cursor_.take_number("matrix entry");
            if (!std::isfinite(static_cast<float>(matrix[i]))) {
                cursor_.fail_taken(
                    fmt::format("matrix entry: got {}, expected a finite number of "
                                "float32",
                                matrix[i]));
            }
        }
        if (kind_ == AuthorsMatrix::log_rotation) {
            for (const std::size_t i : kDiagonal) check(matrix, {i, i}, -1, vertex);
            for (const Channel channel : kSkew) append(matrix, channel, -1, vertex);
        } else {
            for (const Channel channel : kSymmetric) append(matrix, channel, 1, vertex);
        }
    }

    void append(const Matrix& matrix, Channel channel, double sign, std::int64_t vertex) {
        check(matrix, channel, sign, vertex);
        const double mean = 0.5 * (matrix[channel.entry] + sign * matrix[channel.mirror]);
        result_.channels.push_back(static_cast<float>(mean));
    }

    void check(const Matrix& matrix, Channel channel, double sign, std::int64_t vertex) const {
        const double a = matrix[channel.entry], b = matrix[channel.mirror];
        const double size = std::max({1.0, std::abs(a), std::abs(b)});
        if (std::abs(a - sign * b) <= kTolerance * size) return;
        const bool skew = kind_ == AuthorsMatrix::log_rotation;
        cursor_.fail_taken(fmt::format(
            "the matrix of vertex {} (counting from 0) that ends here is not {}: entry {},{} is {} "
            "and entry {},{} is {}; {}",
            vertex, skew ? "skew" : "symmetric", channel.entry / 3 + 1, channel.entry % 3 + 1, a,
            channel.mirror / 3 + 1, channel.mirror % 3 + 1, b,
            skew ? "expected the logarithm of a rotation" : "expected a stretch"));
    }

    TextCursor cursor_;
    AuthorsMatrix kind_;
    const std::string& path_;
    AuthorsText result_;
};

Matrix matrix_of(const float* feature, AuthorsMatrix kind) {
    Matrix matrix{};
    const auto put = [&](Channel channel, float value, float sign) {
        matrix[channel.mirror] = sign * value;
        matrix[channel.entry] = value;
    };
    if (kind == AuthorsMatrix::log_rotation) {
        for (std::size_t i = 0; i < kSkew.size(); ++i) put(kSkew[i], feature[i], -1);
    } else {
        for (std::size_t i = 0; i < kSymmetric.size(); ++i) {
            put(kSymmetric[i], feature[kRotationDim + i], 1);
        }
    }
    return matrix;
}

}  // namespace

AuthorsText parse_authors_text(std::string_view text, AuthorsMatrix kind, const std::string& path) {
    return Reader(text, kind, path).read();
}

std::vector<float> join_authors_text(const AuthorsText& log_rotation, const AuthorsText& stretch,
                                     const std::string& stretch_path) {
    if (log_rotation.shape_count != stretch.shape_count ||
        log_rotation.vertex_count != stretch.vertex_count) {
        throw InputError({stretch_path},
                         fmt::format("{} shapes of {} vertices, but its LOGRNEW file has {} of {}",
                                     stretch.shape_count, stretch.vertex_count,
                                     log_rotation.shape_count, log_rotation.vertex_count));
    }
    std::vector<float> features;
    features.reserve(3 * log_rotation.channels.size());
    auto r = log_rotation.channels.begin();
    for (auto s = stretch.channels.begin(); s != stretch.channels.end(); s += 6, r += 3) {
        features.insert(features.end(), r, r + 3);
        features.insert(features.end(), s, s + 6);
    }
    return features;
}

void write_authors_text(const std::string& path, const FeatureSet& set, AuthorsMatrix kind) {
    AtomicFile file(path);
    std::string line;
    for (int shape = 0; shape < set.shape_count(); ++shape) {
        line.clear();
        const std::span<const float> features = set.shape(shape);
        for (std::size_t at = 0; at < features.size(); at += kFeatureDim) {
            for (const double entry : matrix_of(features.data() + at, kind)) {
                if (!std::isfinite(entry)) {
                    throw NumericalError(fmt::format(
                        "{}: the feature of vertex {} of shape {} is not finite; nothing was "
                        "written",
                        path, at / kFeatureDim, shape));
                }
                fmt::format_to(std::back_inserter(line), "{}{:.9g}", line.empty() ? "" : " ",
                               entry);
            }
        }
        line += '\n';
        file.write(std::string_view(line));
    }
    file.commit();
}

std::string stretch_path_of(const std::string& path) {
    const std::filesystem::path file(path);
    const std::string name = file.filename().string();
    if (!name.starts_with(kStem)) return "";
    return (file.parent_path() / ("S" + name.substr(kStem.size()))).string();
}

}  // namespace mscomp
