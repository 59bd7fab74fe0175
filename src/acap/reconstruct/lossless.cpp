// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>

#include "acap/rotation.h"
#include "anchored_system.h"
#include "lossless_ceres.h"
#include "mscomp/acap/reconstruct.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "position_derivatives.h"
#include "tangential_system.h"
#include "whitened_descent.h"

namespace mscomp {
namespace {

constexpr double kLaplacianShare = 0.01;
// Rounding a rotation vector of some turns to float32 leaves this residual.
constexpr double kFloatRounding = 2e-7;
constexpr double kSmallestStep = 1e-8;  // of the size of the reference

/// Hessian of the energy over 2 with the pseudo-edges held, the same for each coordinate, plus a
/// share of the Laplacian for patterns that alternate from vertex to vertex: the equations without
/// the derivative of the pseudo-edge hardly see them.
MatrixEntries constant_matrix(const FeatureEquations& equations) {
    const DeformationGradients& gradients = equations.gradients();
    MatrixEntries entries;
    add_ring_squares(gradients.rings(), equations.edge_factors(), entries);
    add_laplacian(gradients.rings(), gradients.weights(), kLaplacianShare, entries);
    return entries;
}

double relative_energy(double energy, const std::vector<Eigen::Matrix3d>& wanted) {
    const double size = squared_size(wanted);
    return size > 0 ? energy / size : 0.0;
}

double half_diagonal(const std::vector<Point>& points) {
    double square = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto [low, high] = std::ranges::minmax_element(
            points, {}, [axis](const Point& point) { return point[axis]; });
        square += ((*high)[axis] - (*low)[axis]) * ((*high)[axis] - (*low)[axis]);
    }
    return 0.5 * std::sqrt(square);
}

void check_handles(std::span<const Handle> handles, int vertex_count) {
    for (const Handle& handle : handles) {
        if (handle.vertex < 0 || handle.vertex >= vertex_count) {
            throw UsageError(fmt::format("handle at vertex {}, the mesh has 0 to {}", handle.vertex,
                                         vertex_count - 1));
        }
        if (!(handle.weight > 0)) {
            throw UsageError(
                fmt::format("handle at vertex {}: got the weight {}, wanted a positive number",
                            handle.vertex, handle.weight));
        }
        for (const double x : handle.position) {
            if (std::isfinite(x)) continue;
            throw UsageError(
                fmt::format("handle at vertex {}: got the coordinate {}, wanted a "
                            "finite number",
                            handle.vertex, x));
        }
    }
}

/// Translates every component that has handles so that they are met on average.
void move_to_handles(std::span<const Handle> handles, const Placement& placement,
                     std::vector<Point>& positions) {
    std::vector<Point> shift(at(placement.component_count()), Point{});
    std::vector<int> count(shift.size(), 0);
    for (const Handle& handle : handles) {
        const auto vertex = at(handle.vertex);
        const auto c = at(placement.component()[vertex]);
        ++count[c];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            shift[c][axis] += handle.position[axis] - positions[vertex][axis];
        }
    }
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const auto c = at(placement.component()[i]);
        if (count[c] == 0) continue;
        for (std::size_t axis = 0; axis < 3; ++axis)
            positions[i][axis] += shift[c][axis] / count[c];
    }
}

}  // namespace

struct LosslessReconstruction::State : TangentialSystem {
    State(const TriangleMesh& mesh, EdgeWeights weights)
        : TangentialSystem(mesh, weights),
          poisson(mesh, weights),
          smallest_step(kSmallestStep * half_diagonal(mesh.vertices)) {}

    /// Features of meshes never come to need it, so it waits for the first that do.
    const AnchoredSystem& system() const {
        std::call_once(once_, [this] {
            system_.emplace(constant_matrix(equations),
                            static_cast<int>(placement.component().size()),
                            placement.first_vertices(), "the matrix of the lossless reconstruction",
                            &tangential.system());
        });
        return *system_;
    }

    PoissonReconstruction poisson;
    double smallest_step;

  private:
    mutable std::once_flag once_;
    mutable std::optional<AnchoredSystem> system_;
};

LosslessReconstruction::LosslessReconstruction(const TriangleMesh& reference, EdgeWeights weights)
    : state_(std::make_unique<State>(reference, weights)) {}
LosslessReconstruction::LosslessReconstruction(LosslessReconstruction&&) noexcept = default;
LosslessReconstruction& LosslessReconstruction::operator=(LosslessReconstruction&&) noexcept =
    default;
LosslessReconstruction::~LosslessReconstruction() = default;

ReconstructedShape LosslessReconstruction::solve(std::span<const float> features,
                                                 std::span<const Point> like, Pieces pieces) const {
    const State& state = *state_;
    ReconstructedShape result;
    result.vertices = state.poisson.solve(features, like, pieces);
    const std::vector<Eigen::Matrix3d> gradients =
        gradients_of_features(features, result.vertices.size());
    const std::vector<Eigen::Matrix3d> wanted = state.equations.wanted(gradients);
    state.tangential.apply(wanted, result.vertices);
    result.residual = state.tangential.residual(wanted, result.vertices);
    const auto energy = [&](const std::vector<Point>& x, std::vector<Point>& derivative) {
        return state.equations.energy(x, wanted, derivative);
    };
    // Features of a mesh have their mesh already. Its own features need not come out again: where
    // a face has hardly any area, rounding turns its normal.
    if (result.residual <= kFloatRounding) {
        std::vector<Point> unused;
        result.energy = relative_energy(energy(result.vertices, unused), wanted);
        result.converged = true;
    } else {
        DescentOptions options;
        options.largest_step = state.smallest_step;
        const DescentResult found = descend(energy, state.system(), result.vertices, options);
        result.energy = relative_energy(found.value, wanted);
        result.steps = found.steps;
        result.converged = found.converged;
    }
    if (like.empty() || pieces == Pieces::joined) {
        state.placement.join(gradients, like, result.vertices);
    } else {
        state.placement.apply(like, result.vertices);
    }
    return result;
}

void LosslessReconstruction::derivatives(std::span<const float> features,
                                         std::span<const FeatureDirection> directions,
                                         std::span<double> result) const {
    position_derivatives(state_->positions(), features, directions, result);
}

ReconstructedShape LosslessReconstruction::solve_by_ceres(std::span<const float> features,
                                                          std::span<const Handle> handles,
                                                          std::span<const Point> like) const {
    const State& state = *state_;
    ReconstructedShape result;
    result.vertices = state.poisson.solve(features, like);
    check_handles(handles, static_cast<int>(result.vertices.size()));
    const std::vector<Eigen::Matrix3d> wanted =
        state.equations.wanted(gradients_of_features(features, result.vertices.size()));
    state.tangential.apply(wanted, result.vertices);
    move_to_handles(handles, state.placement, result.vertices);
    std::vector<char> has_handle(at(state.placement.component_count()), 0);
    for (const Handle& handle : handles) {
        const int c = state.placement.component()[at(handle.vertex)];
        has_handle[at(c)] = 1;
    }
    std::vector<int> held;
    for (const int vertex : state.placement.first_vertices()) {
        const int c = state.placement.component()[at(vertex)];
        if (has_handle[at(c)] == 0) held.push_back(vertex);
    }
    refine_by_ceres(state.equations, wanted, handles, held, result);
    result.residual = state.tangential.residual(wanted, result.vertices);
    std::vector<Point> unused;
    result.energy =
        relative_energy(state.equations.energy(result.vertices, wanted, unused), wanted);
    state.placement.apply(like, result.vertices, has_handle);
    return result;
}

}  // namespace mscomp
