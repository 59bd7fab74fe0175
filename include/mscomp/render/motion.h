// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "mscomp/render/render.h"
#include "mscomp/render/viewpoint.h"

namespace mscomp {

/// Vertices count as moving from this share of the largest displacement on.
constexpr double kMovingShare = 0.25;

/// How far the vertices of a reference are moved.
struct Motion {
    std::vector<double> amount;  // (V), in the unit of the mesh
    double largest = 0;
    std::vector<int> moving;  // those of at least kMovingShare of the largest, rising; none if it
                              // is 0
};

/// Both (V). Throws UsageError for sizes that differ.
Motion motion_of(std::span<const Point> reference, std::span<const Point> moved);

/// The same direction of view, of the moving vertices where they were and where they are, with an
/// eighth around them, but no closer than an eighth of the whole; the whole shape where they take
/// up three quarters of it or nothing moves.
View zoomed(const View& view, std::span<const Point> reference, std::span<const Point> moved,
            const Motion& motion, double picture_aspect = 1.0);

/// How much of the motion is seen along the axes of `view`: the integral over the picture of the
/// moving vertices of what is in front there of (|d| + |d in the picture|) / 2, d being the
/// displacement, in mesh units cubed. Motion that is hidden, on faces seen edge-on, or on the
/// inside of what encloses a volume does not count, motion towards the viewer counts half. Pictures
/// of 64 x 64 samples; the same scale for all directions.
double visible_motion(const TriangleMesh& reference, std::span<const Point> moved,
                      const Motion& motion, const std::array<Point, 3>& axes);

/// What is tried, the front first: eight azimuths slightly from above, four from 60 degrees above
/// and four from 45 degrees below.
const std::vector<Viewpoint>& tried_viewpoints();

/// visible_motion from each of tried_viewpoints().
std::vector<double> motion_from_viewpoints(const TriangleMesh& reference,
                                           std::span<const Point> moved, const Motion& motion,
                                           const Stance& stance);

/// A view other than the front has to show this much more, so that pictures stay alike, and one
/// from far above or below that much.
constexpr double kWorthTurning = 1.2, kWorthRising = 2;

/// The viewpoint that shows most, weighed so.
Viewpoint most_telling(const std::vector<double>& shown);

/// Turns `stance` by quarters about its up axis to where `shown`, one list per motion, is largest
/// in all, each list counting alike; only for more than kWorthTurning times as much. Turns the
/// lists with it.
void face_motion(Stance& stance, std::vector<std::vector<double>>& shown);

}  // namespace mscomp
