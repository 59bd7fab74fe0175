// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <utility>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/index.h"
#include "mscomp/base/random.h"
#include "mscomp/model/shape_model.h"

namespace mscomp::cases {

/// Numbers of N(0, 1).
inline Eigen::MatrixXd normal_numbers(Eigen::Index rows, Eigen::Index columns, int seed) {
    const CounterRandom random(static_cast<std::uint64_t>(seed), 0);
    Eigen::MatrixXd result(rows, columns);
    for (Eigen::Index i = 0; i < result.size(); ++i) {
        result.data()[i] = random.normal(static_cast<std::uint64_t>(i));
    }
    return result;
}

inline CodeTable table_of(const Eigen::MatrixXd& codes) {
    CodeTable table{static_cast<int>(codes.cols()), {}};
    for (Eigen::Index n = 0; n < codes.rows(); ++n) {
        for (Eigen::Index k = 0; k < codes.cols(); ++k) {
            table.values.push_back(static_cast<float>(codes(n, k)));
        }
    }
    return table;
}

/// Rows of the reference, all 0, and a change (9 V) for each code, a column of `changes`.
class LinearModel final : public ShapeModel {
  public:
    explicit LinearModel(Eigen::MatrixXd changes, std::vector<float> reference = {}, int coarse = 0)
        : changes_(std::move(changes)), reference_(std::move(reference)), coarse_(coarse) {
        if (reference_.empty()) reference_.assign(at(changes_.cols()), 0.0F);
    }

    ShapeRows rows() const override { return ShapeRows::features; }
    int vertex_count() const override { return static_cast<int>(changes_.rows()) / kFeatureDim; }
    std::vector<LevelSize> levels() const override {
        const int count = static_cast<int>(changes_.cols());
        if (coarse_ == 0) return {{1, count}};
        return {{1, coarse_}, {1, count - coarse_}};
    }
    std::vector<int> parents() const override {
        std::vector<int> parents(at(changes_.cols()), -1);
        if (coarse_ > 0) std::fill(parents.begin() + coarse_, parents.end(), 0);
        return parents;
    }
    CodeTable encode(const ShapeSet& /*shapes*/, std::span<const int> /*which*/) override {
        return table_of(encoded);
    }
    std::vector<float> reference_codes() override { return reference_; }
    std::vector<float> decode(std::span<const float> codes, int /*levels*/) const override {
        return change(codes, reference_);
    }
    std::vector<float> change(std::span<const float> codes,
                              std::span<const float> from) const override {
        Eigen::VectorXd away(changes_.cols());
        for (Eigen::Index k = 0; k < away.size(); ++k) {
            away[k] = static_cast<double>(codes[at(k)]) - static_cast<double>(from[at(k)]);
        }
        const Eigen::VectorXf rows = (changes_ * away).cast<float>();
        return {rows.begin(), rows.end()};
    }
    std::vector<CodeColumn> derivatives(std::span<const float> /*codes*/) const override {
        std::vector<CodeColumn> columns(at(changes_.cols()));
        for (std::size_t k = 0; k < columns.size(); ++k) {
            for (int v = 0; v < vertex_count(); ++v) {
                const auto row = changes_.col(static_cast<Eigen::Index>(k)).segment<9>(9 * v);
                if (row.isZero(0)) continue;
                columns[k].vertices.push_back(v);
                for (const double x : row) columns[k].values.push_back(static_cast<float>(x));
            }
        }
        return columns;
    }
    std::vector<ComponentPlace> places() const override {
        std::vector<ComponentPlace> places;
        for (const CodeColumn& column : derivatives({})) {
            places.push_back({0, 0, static_cast<int>(column.vertices.size())});
        }
        return places;
    }

    Eigen::MatrixXd encoded;  // what encode() gives

  private:
    Eigen::MatrixXd changes_;
    std::vector<float> reference_;
    int coarse_;
};

/// Every vertex is nowhere.
class NoDistances final : public DistanceRows {
  public:
    explicit NoDistances(int count) : zeros_(at(count), 0.0) {}
    int vertex_count() const override { return static_cast<int>(zeros_.size()); }
    std::span<const double> row(int /*vertex*/) override { return zeros_; }

  private:
    std::vector<double> zeros_;
};

}  // namespace mscomp::cases
