// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mscomp/render/family_layout.h"
#include "mscomp/render/motion.h"
#include "mscomp/render/render.h"
#include "mscomp/render/viewpoint.h"

namespace mscomp {

/// What moves less than this share of the motion that moves most is near-empty.
constexpr double kNearEmptyShare = 0.03;

/// One component as it is drawn.
struct ShownMotion {
    std::string name;
    int parent = -1;           // its number in the list, which is smaller
    std::vector<Point> moved;  // (V) places of the vertices; empty: only the name is shown, greyed
};

struct OverviewOptions {
    std::string title;
    int tile = 240;                 // pixels per side of one picture
    int columns = 8;                // at most
    std::optional<Point> up;        // otherwise guessed
    std::optional<Viewpoint> view;  // of all; otherwise chosen for each
};

/// How one component is drawn.
struct OverviewTile {
    Motion motion;
    Viewpoint viewpoint;
    View zoom, whole;
    bool is_zoomed = false;   // the whole is drawn beside it
    bool near_empty = false;  // drawn greyed, with words
};

struct OverviewPlan {
    Stance stance;
    bool is_up_guessed = true;
    double diagonal = 0;  // of the bounding box of the reference: the unit of displacements is 1 %
    double largest = 0;   // displacement of all, in percent: the end of the one colour scale
    std::vector<OverviewTile> tiles;  // one for each motion
    FamilyLayout layout;
};

/// Decides everything but the pixels. The same for any number of threads. Throws UsageError (sizes
/// that differ, parents as family_layout) or MeshError (as render_mesh).
OverviewPlan plan_overview(const TriangleMesh& reference, std::span<const ShownMotion> motions,
                           const OverviewOptions& options);

/// Displacements, in percent, at five places evenly spaced on the colour bar, from 0 to `largest`:
/// the colour goes with the square root, so that small motions are seen beside large ones.
std::vector<double> scale_ticks(double largest);
/// Place of a displacement on the colour bar, from 0 to 1.
double place_on_scale(double percent, double largest);

/// The sheet: the reference with the colour bar and how to read it, then every component beside its
/// parent, zoomed to what moves, with a small whole. The same bytes for any number of threads.
/// Throws as render_mesh.
Image draw_overview(const TriangleMesh& reference, std::span<const ShownMotion> motions,
                    const OverviewPlan& plan, const OverviewOptions& options);

}  // namespace mscomp
