// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "learning/deflation_residual.h"
#include "mscomp/base/distance_rows.h"

namespace mscomp {

struct FoundComponent {
    int center = 0;
    DeflationDirection direction;
    double energy = -1;  // explained by it
};

/// Indices of those of `vertices` where a component around `center` may act, rising.
using FreePlaces = std::function<std::vector<int>(int center, std::span<const int> vertices)>;

/// How many vertices a start looks at besides the strongest.
inline constexpr int kCandidates = 64;

/// Vertices spread over the mesh, each as far as possible from those before it; the first is 0.
std::vector<int> spread_vertices(DistanceRows& distances, int most);

/// Below this part of the energy that there was at first there is only rounding left.
inline constexpr double kNothingLeft = 1e-10;

/// Whether there are components enough around a vertex.
using IsCrowded = std::function<bool(int center)>;

/// Takes directions out of a residual one after the other: around the one of `candidates` or the
/// strongest vertex where most energy is left within reach, then around where the direction is
/// longest, as long as that explains more. The energy of a whole ball counts, since a component has
/// to serve all of it: single hot vertices would leave the ground between them to too few
/// components.
class Deflation {
  public:
    /// Borrows residual and distances. `first_energy` is what the residual had before anything was
    /// taken out.
    Deflation(DeflationResidual& residual, double first_energy, DistanceRows& distances,
              FreePlaces free_places, std::span<const int> candidates);

    /// The next one, taken out. Where there is nothing left it is all zero and has the centre that
    /// was tried last. No centre lies where `is_crowded` unless all candidates do.
    FoundComponent next(const IsCrowded& is_crowded = {});

  private:
    /// Where a component can start: a vertex and what lies within its reach.
    struct Candidate {
        int center;
        std::vector<int> places;
    };
    int strongest_center(const IsCrowded& is_crowded) const;
    FoundComponent around(int center, const IsCrowded& is_crowded) const;

    DeflationResidual& residual_;
    DistanceRows& distances_;
    FreePlaces free_places_;
    std::vector<Candidate> candidates_;
    double first_energy_;
};

/// So many `components` of a Deflation.
std::vector<FoundComponent> deflate(DeflationResidual& residual, int components,
                                    DistanceRows& distances, const FreePlaces& free_places,
                                    std::span<const int> candidates);

/// Writes a direction into component weights (V,width), its first channels where width is less
/// than nine; others stay as they are.
template <class T>
void write_direction(const DeflationResidual& residual, const DeflationDirection& direction,
                     std::int64_t width, std::span<T> row);

}  // namespace mscomp
