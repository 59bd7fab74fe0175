// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace mscomp {

enum class AxisScale { linear, logarithmic };

/// Round numbers for an axis, ascending and evenly spaced, the first <= low and the last >= high:
/// 1, 2 or 5 times a power of ten apart, at most `most` of them (at least 3). Equal ends get an
/// axis around them. Throws UsageError for ends that are not finite or not in order, or `most` < 3.
std::vector<double> round_ticks(double low, double high, int most);

/// The same for a logarithmic axis: 1, 2 and 5 times powers of ten, or powers of ten only where
/// those would be more than `most`, or every second, third, ... of them. Throws as round_ticks, and
/// for low <= 0.
std::vector<double> log_ticks(double low, double high, int most);

/// Points joined by lines in the order given; those that are not finite are left out.
struct LineSeries {
    std::string label;
    std::vector<double> x, y;  // as many
};

struct LinePlot {
    std::string title, x_label, y_label;
    AxisScale x_scale = AxisScale::linear, y_scale = AxisScale::linear;
    std::vector<LineSeries> series;
};

/// One bar per category, from 0 (logarithmic: from the lowest tick); none where it is not finite.
struct BarSeries {
    std::string label;
    std::vector<double> values;  // as many as there are categories
};

struct BarPlot {
    std::string title, x_label, y_label;
    AxisScale y_scale = AxisScale::linear;
    std::vector<std::string> categories;
    std::vector<BarSeries> series;
};

/// The picture as an SVG document that needs nothing beside it: axes with round ticks that cover
/// all points, one element of class "marker" (or "bar") per point, which shows its numbers where
/// the pointer rests on it, a legend where a series has a label. The same bytes for the same input.
/// Text is UTF-8; control characters become '?'. Throws UsageError for sizes that differ, and for
/// numbers <= 0 on a logarithmic axis.
std::string line_plot_svg(const LinePlot& plot);
std::string bar_plot_svg(const BarPlot& plot);

}  // namespace mscomp
