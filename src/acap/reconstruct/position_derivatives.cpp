// SPDX-License-Identifier: MIT
#include "position_derivatives.h"

#include <array>
#include <cassert>

#include "acap/rotation.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t kLanes = 8;
// Directions whose three coordinates fill whole blocks of lanes.
constexpr std::size_t kDirections = 8;
constexpr std::size_t kBlocks = 3 * kDirections / kLanes;

/// What the derivative of T = exp(r) S needs at one vertex.
struct Factors {
    Matrix3d gradient, rotation, left_jacobian;

    /// dT = [J_l(r) dr]x T + exp(r) dS.
    Matrix3d change(const float* feature) const {
        const auto entry = [&](int channel) { return static_cast<double>(feature[channel]); };
        const Vector3d turn = left_jacobian * Vector3d(entry(0), entry(1), entry(2));
        Matrix3d by_turn, stretch;
        by_turn << 0, -turn.z(), turn.y(),  //
            turn.z(), 0, -turn.x(),         //
            -turn.y(), turn.x(), 0;
        stretch << entry(3), entry(4), entry(5),  //
            entry(4), entry(6), entry(7),         //
            entry(5), entry(7), entry(8);
        return by_turn * gradient + rotation * stretch;
    }
};

std::vector<Factors> factors_of(std::span<const float> features, std::size_t vertex_count) {
    const std::vector<Matrix3d> gradients = gradients_of_features(features, vertex_count);
    std::vector<Factors> factors(vertex_count);
    for (std::size_t i = 0; i < vertex_count; ++i) {
        const float* f = features.data() + i * kFeatureDim;
        const Vector3d r = Eigen::Map<const Eigen::Vector3f>(f).cast<double>();
        factors[i] = {gradients[i], rotation_exp(r), rotation_left_jacobian(r)};
    }
    return factors;
}

/// Up to kDirections directions, solved together.
class Group {
  public:
    explicit Group(const LinearPositions& positions) : positions_(positions) {
        for (auto& rows : rows_) rows.assign(vertex_count(), Lanes<kLanes>{});
        if (!positions.placement.has_joints()) return;
        for (auto& changes : changes_) changes.assign(vertex_count(), Matrix3d::Zero());
    }

    void add(std::size_t place, const FeatureDirection& direction,
             const std::vector<Factors>& factors) {
        assert(direction.values.size() == direction.vertices.size() * kFeatureDim);
        const OneRings& rings = positions_.rings;
        for (std::size_t n = 0; n < direction.vertices.size(); ++n) {
            const auto v = at(direction.vertices[n]);
            const Matrix3d change = factors[v].change(direction.values.data() + n * kFeatureDim);
            Vector3d own = Vector3d::Zero();
            for (int entry = rings.offsets[v]; entry < rings.offsets[v + 1]; ++entry) {
                const auto k = at(entry);
                const Vector3d pull = change * positions_.pulls[k];
                add(at(rings.neighbors[k]), place, pull);
                own -= pull;
            }
            add(v, place, own);
            if (!changes_[place].empty()) changes_[place][v] = change;
        }
    }

    void solve() {
        std::vector<Lanes<kLanes>> work, scratch;
        for (auto& rows : rows_) positions_.system.solve(rows, work, scratch);
    }

    /// The change of all positions along the direction at `place`, the components joined.
    void get(std::size_t place, std::span<double> changes) const {
        const std::vector<int>& component = positions_.placement.component();
        const std::vector<Vector3d> shifts = shifts_of_components(place);
        Vector3d mean = Vector3d::Zero();
        for (std::size_t i = 0; i < vertex_count(); ++i) {
            mean += row(i, place) + shifts[at(component[i])];
        }
        mean /= static_cast<int>(vertex_count());
        for (std::size_t i = 0; i < vertex_count(); ++i) {
            Eigen::Map<Vector3d>(changes.data() + 3 * i) =
                row(i, place) + shifts[at(component[i])] - mean;
        }
    }

  private:
    std::size_t vertex_count() const { return positions_.placement.component().size(); }

    std::vector<Vector3d> shifts_of_components(std::size_t place) const {
        return positions_.placement.shifts(
            [&](int v) { return row(at(v), place); },
            [&](int v) -> const Matrix3d& { return changes_[place][at(v)]; });
    }

    void add(std::size_t vertex, std::size_t place, const Vector3d& value) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::size_t lane = 3 * place + axis;
            rows_[lane / kLanes][vertex][lane % kLanes] += value[static_cast<Eigen::Index>(axis)];
        }
    }
    Vector3d row(std::size_t vertex, std::size_t place) const {
        const auto entry = [&](std::size_t lane) {
            return rows_[lane / kLanes][vertex][lane % kLanes];
        };
        return {entry(3 * place), entry(3 * place + 1), entry(3 * place + 2)};
    }

    const LinearPositions& positions_;
    std::array<std::vector<Lanes<kLanes>>, kBlocks> rows_;    // (V, kLanes) each
    std::array<std::vector<Matrix3d>, kDirections> changes_;  // (V) dT, if components are joined
};

}  // namespace

void position_derivatives(const LinearPositions& positions, std::span<const float> features,
                          std::span<const FeatureDirection> directions, std::span<double> result) {
    const std::vector<Factors> factors =
        factors_of(features, positions.placement.component().size());
    const std::size_t size = 3 * factors.size();
    assert(result.size() == directions.size() * size);
    const Chunks groups{static_cast<std::int64_t>(directions.size()), kDirections};
    parallel_for(groups.count(), [&](std::int64_t g) {
        const auto first = at(groups.begin(g));
        const auto last = at(groups.end(g));
        Group group(positions);
        for (std::size_t k = first; k < last; ++k) group.add(k - first, directions[k], factors);
        group.solve();
        for (std::size_t k = first; k < last; ++k) {
            group.get(k - first, result.subspan(k * size, size));
        }
    });
}

}  // namespace mscomp
