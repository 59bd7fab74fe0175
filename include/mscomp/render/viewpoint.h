// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// How a shape stands: unit vectors at right angles. The right of the front is that of a viewer who
/// looks at it: up x front.
struct Stance {
    Point up{0, 1, 0}, front{0, 0, 1};
};

/// Where the viewer is, in degrees. Azimuth 0 is in front, 90 to the right of the front, 180
/// behind; elevation 90 is above, with what is behind at the top of the picture.
struct Viewpoint {
    double azimuth = 0, elevation = 0;

    bool operator==(const Viewpoint&) const = default;
};

/// A guess from the extents along the coordinate axes:
/// * up is +y, unless the longest extent is more than twice that of y: then that axis is up (a
///   person who stands along x or z, a limb);
/// * the front is along the shorter of the two other extents, on its positive side where y is up,
///   on its negative side elsewhere, as most modelling programs have it.
Stance stance_of(std::span<const Point> vertices);
/// The same front for an `up` that is known, a coordinate axis or its opposite.
Stance stance_of(std::span<const Point> vertices, const Point& up);

/// Of surfaces that are open, such as a face: the mean normal, weighted by area, shows where their
/// front is. Turns `stance` there, to a coordinate axis that is within 30 degrees of it, and says
/// so; does nothing where the mean normal of all faces, without its part along up, is shorter than
/// 0.15. It is 0 for a closed surface.
bool face_open_front(const TriangleMesh& mesh, Stance& stance);

/// Right, up and towards-the-viewer axes of a picture from there (View::axes).
std::array<Point, 3> axes_from(const Stance& stance, const Viewpoint& viewpoint);

/// "front", "back left", "above, right": what a caption says. Left and right are those of a viewer
/// of the front.
std::string name_of(const Viewpoint& viewpoint);
/// "+y", "-z"; "(0.71, 0, 0.71)" for what is no coordinate axis.
std::string axis_name(const Point& direction);

/// x, y, z, -x, -y or -z. Throws UsageError.
Point parse_axis(std::string_view text);
/// front, back, left, right, top, bottom, or "azimuth,elevation" in degrees with an elevation from
/// -90 to 90. Throws UsageError.
Viewpoint parse_viewpoint(std::string_view text);

}  // namespace mscomp
