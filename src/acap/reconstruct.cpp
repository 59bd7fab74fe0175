// SPDX-License-Identifier: MIT
#include "mscomp/acap/reconstruct.h"

#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <cmath>

#include "edge_weights.h"
#include "mscomp/base/error.h"
#include "rotation.h"

namespace mscomp {
namespace {

using Positions = Eigen::Matrix<double, Eigen::Dynamic, 3>;

std::vector<Eigen::Matrix3d> gradients_of_features(std::span<const float> features) {
    std::vector<Eigen::Matrix3d> gradients(features.size() / kFeatureDim);
    for (std::size_t i = 0; i < gradients.size(); ++i) {
        gradients[i] = gradient_of_feature(features.subspan(i * kFeatureDim).first<kFeatureDim>());
        if (!gradients[i].allFinite()) {
            throw NumericalError(fmt::format("feature of vertex {} is not finite", i));
        }
    }
    return gradients;
}

/// (C,3) mean position of every connected component.
Positions centroids(const Positions& positions, const std::vector<int>& component, int count) {
    Positions sums = Positions::Zero(count, 3);
    Eigen::VectorXd sizes = Eigen::VectorXd::Zero(count);
    for (std::size_t i = 0; i < component.size(); ++i) {
        sums.row(component[i]) += positions.row(static_cast<Eigen::Index>(i));
        sizes[component[i]] += 1;
    }
    for (int c = 0; c < count; ++c) sums.row(c) /= sizes[c];
    return sums;
}

}  // namespace

struct PoissonReconstruction::State {
    OneRings rings;
    std::vector<double> weights;  // beside rings.neighbors
    Positions reference;          // (V,3)
    std::vector<int> component;   // (V)
    int component_count = 0;
    std::vector<int> unknown;  // (V) row of the system, -1 for the anchors
    int unknown_count = 0;
    Positions reference_centroids;  // (C,3)
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> laplacian;

    void number_unknowns();
    void factorize();
    Positions right_hand_side(const std::vector<Eigen::Matrix3d>& gradients) const;
};

void PoissonReconstruction::State::number_unknowns() {
    unknown.assign(component.size(), -1);
    for (std::size_t i = 0; i < component.size(); ++i) {
        // Components are numbered by their lowest vertex, which is the one that is held.
        if (component[i] == component_count) {
            ++component_count;
        } else {
            unknown[i] = unknown_count++;
        }
    }
}

void PoissonReconstruction::State::factorize() {
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(rings.neighbors.size() + component.size());
    for (std::size_t i = 0; i < component.size(); ++i) {
        if (unknown[i] < 0) continue;
        double sum = 0;
        for (int at = rings.offsets[i]; at < rings.offsets[i + 1]; ++at) {
            const auto k = static_cast<std::size_t>(at);
            sum += weights[k];
            const int column = unknown[static_cast<std::size_t>(rings.neighbors[k])];
            if (column >= 0) entries.emplace_back(unknown[i], column, -weights[k]);
        }
        entries.emplace_back(unknown[i], unknown[i], sum);
    }
    Eigen::SparseMatrix<double> matrix(unknown_count, unknown_count);
    matrix.setFromTriplets(entries.begin(), entries.end());
    laplacian.compute(matrix);
    if (laplacian.info() != Eigen::Success) {
        throw NumericalError("the Laplacian of the reference could not be factorised");
    }
}

/// Rows ½ Σ_j c_ij (T_i + T_j)(p_i - p_j) of the vertices that are not held.
Positions PoissonReconstruction::State::right_hand_side(
    const std::vector<Eigen::Matrix3d>& gradients) const {
    Positions rows = Positions::Zero(unknown_count, 3);
    for (std::size_t i = 0; i < component.size(); ++i) {
        if (unknown[i] < 0) continue;
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int at = rings.offsets[i]; at < rings.offsets[i + 1]; ++at) {
            const auto k = static_cast<std::size_t>(at);
            const int j = rings.neighbors[k];
            const Eigen::Vector3d edge =
                reference.row(static_cast<Eigen::Index>(i)) - reference.row(j);
            sum +=
                0.5 * weights[k] * ((gradients[i] + gradients[static_cast<std::size_t>(j)]) * edge);
        }
        rows.row(unknown[i]) = sum;
    }
    return rows;
}

PoissonReconstruction::PoissonReconstruction(const TriangleMesh& reference, EdgeWeights weights)
    : state_(std::make_unique<State>()) {
    State& state = *state_;
    state.rings = one_rings_of_faces(reference.vertex_count(), reference.faces);
    state.weights = edge_weights(reference, state.rings, weights).weights;
    state.reference.resize(reference.vertex_count(), 3);
    for (int i = 0; i < reference.vertex_count(); ++i) {
        state.reference.row(i) = as_vector(reference.vertices[static_cast<std::size_t>(i)]);
    }
    state.component = connected_components(state.rings);
    state.number_unknowns();
    state.reference_centroids = centroids(state.reference, state.component, state.component_count);
    state.factorize();
}

PoissonReconstruction::PoissonReconstruction(PoissonReconstruction&&) noexcept = default;
PoissonReconstruction& PoissonReconstruction::operator=(PoissonReconstruction&&) noexcept = default;
PoissonReconstruction::~PoissonReconstruction() = default;

std::vector<Point> PoissonReconstruction::solve(std::span<const float> features) const {
    const State& state = *state_;
    const std::size_t count = state.component.size();
    if (features.size() != count * kFeatureDim) {
        throw MeshError(fmt::format("{} feature values, wanted {} x {} for this reference",
                                    features.size(), count, kFeatureDim));
    }
    const Positions solution =
        state.laplacian.solve(state.right_hand_side(gradients_of_features(features)));
    Positions positions = Positions::Zero(static_cast<Eigen::Index>(count), 3);
    for (std::size_t i = 0; i < count; ++i) {
        if (state.unknown[i] < 0) continue;
        positions.row(static_cast<Eigen::Index>(i)) = solution.row(state.unknown[i]);
    }
    const Positions shift =
        state.reference_centroids - centroids(positions, state.component, state.component_count);
    std::vector<Point> result(count);
    for (std::size_t i = 0; i < count; ++i) {
        Eigen::Map<Eigen::RowVector3d>(result[i].data()) =
            positions.row(static_cast<Eigen::Index>(i)) + shift.row(state.component[i]);
    }
    return result;
}

}  // namespace mscomp
