// SPDX-License-Identifier: MIT
// A decoder in closed form, for tests of what works on codes.
#pragma once

#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "acap/acap_cases.h"
#include "mscomp/base/metric_scale.h"
#include "mscomp/model/shape_model.h"

namespace mscomp::cases {

/// Different for r and S, exact in float.
inline MetricScale wave_scale() {
    MetricScale scale;
    for (std::size_t c = 0; c < kFeatureDim; ++c) {
        scale.offset[c] = static_cast<double>(kReferenceFeature[c]);
        scale.factor[c] = c < kRotationDim ? 0.5 : 2;
    }
    return scale;
}

/// Features of wave_scale() times f(bias + Σ_k z_k D_k), D_k random waves on part of the mesh.
class WaveModel : public ShapeModel {
  public:
    static constexpr int kCodes = 7;
    enum class Kind {
        tanh,       // f = tanh, with a bias
        linear,     // f(x) = x, no bias, D_k multiples of 2^-8: the code 0 decodes to zeros
        redundant,  // tanh; D_1 = D_0, and the last is 0
        breaking,   // tanh; not finite where a code is beyond 1/2
    };

    WaveModel(const TriangleMesh& mesh, Kind kind) : kind_(kind), count_(mesh.vertex_count()) {
        const std::size_t size = at(count_) * kFeatureDim;
        directions_.assign(kCodes, std::vector<float>(size, 0.0F));
        bias_.assign(size, 0.0F);
        Draws draws(77);
        // Waves in normalised coordinates, so that the unit of the mesh does not show.
        double reach = 0;
        for (const Point& p : mesh.vertices) reach = std::max(reach, largest(vec(p)));
        for (int k = 0; k < kCodes; ++k) {
            const Vector3d wave = 2 * draws.vector(), center = draws.vector();
            for (int c = 0; c < kFeatureDim; ++c) {
                const double strength = 0.3 * draws.next(), phase = 3 * draws.next();
                for (int i = 0; i < count_; ++i) {
                    const Vector3d p = vec(mesh.vertices[at(i)]) / reach;
                    if (k > 1 && (p - center).norm() > 1.3) continue;
                    const double x = strength * std::sin(wave.dot(p) + phase);
                    directions_[at(k)][at(i * kFeatureDim + c)] =
                        static_cast<float>(std::round(256 * x) / 256);
                }
            }
        }
        if (kind == Kind::linear) return;
        for (float& b : bias_) b = static_cast<float>(0.05 * draws.next());
        if (kind != Kind::redundant) return;
        directions_[1] = directions_[0];
        directions_.back().assign(size, 0.0F);
    }

    ShapeRows rows() const override { return ShapeRows::features; }
    std::vector<LevelSize> levels() const override { return {{1, kCodes}}; }
    int vertex_count() const override { return count_; }

    std::vector<float> decode(std::span<const float> codes, int /*levels*/ = 0) const override {
        std::vector<float> result(bias_.size());
        for (std::size_t i = 0; i < result.size(); ++i) {
            const double x = sum(codes, i);
            result[i] = static_cast<float>(kind_ == Kind::linear ? x : std::tanh(x));
        }
        if (kind_ == Kind::breaking) {
            for (const float z : codes) {
                if (std::abs(z) > 0.5F) result[3] = std::numeric_limits<float>::infinity();
            }
        }
        wave_scale().unscale(result);
        return result;
    }
    // The fit asks for nothing of these.
    std::vector<float> change(std::span<const float>, std::span<const float>) const override {
        return {};
    }
    CodeTable encode(const ShapeSet&, std::span<const int>) override { return {}; }
    std::vector<float> reference_codes() override { return {}; }
    std::vector<ComponentPlace> places() const override { return {}; }

    std::vector<CodeColumn> derivatives(std::span<const float> codes) const override {
        std::vector<CodeColumn> columns(kCodes);
        for (std::size_t k = 0; k < columns.size(); ++k) {
            for (int v = 0; v < count_; ++v) {
                const float* row = directions_[k].data() + at(v) * kFeatureDim;
                if (std::all_of(row, row + kFeatureDim, [](float x) { return x == 0; })) continue;
                columns[k].vertices.push_back(v);
                for (int c = 0; c < kFeatureDim; ++c) {
                    const double y = std::tanh(sum(codes, at(v * kFeatureDim + c)));
                    const double slope = kind_ == Kind::linear ? 1 : 1 - y * y;
                    const double unscaled =
                        static_cast<double>(static_cast<float>(slope * row[c])) /
                        wave_scale().factor[at(c)];
                    columns[k].values.push_back(static_cast<float>(unscaled));
                }
            }
        }
        return columns;
    }

  private:
    double sum(std::span<const float> codes, std::size_t i) const {
        double x = static_cast<double>(bias_[i]);
        for (std::size_t k = 0; k < codes.size(); ++k) {
            x += static_cast<double>(codes[k]) * static_cast<double>(directions_[k][i]);
        }
        return x;
    }

    Kind kind_;
    int count_;
    std::vector<std::vector<float>> directions_;  // (K,V,9)
    std::vector<float> bias_;                     // (V,9)
};

/// Codes of some size, fixed for a stream.
inline std::vector<float> some_codes(std::uint64_t stream, double size) {
    Draws draws(stream);
    std::vector<float> codes;
    for (int k = 0; k < WaveModel::kCodes; ++k) {
        codes.push_back(static_cast<float>(size * draws.next()));
    }
    return codes;
}

}  // namespace mscomp::cases
