// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "mscomp/base/index.h"
#include "mscomp/base/parsed_number.h"
#include "mscomp/render/plot.h"
#include "sweep_table.h"

namespace mscomp {
namespace {

std::optional<double> number_in(const std::string& text) {
    const auto value = parsed_number<double>(text);
    return value && std::isfinite(*value) ? value : std::nullopt;
}

/// What a row has of `column`: a key, a measure or its name.
std::string text_of(const SweepFile& sweep, const SweepRow& row, const std::string& column) {
    const auto key = std::ranges::find(sweep.keys, column);
    if (key != sweep.keys.end()) {
        return row.values[at(key - sweep.keys.begin())];
    }
    const auto measure = row.measures.find(column);
    if (measure != row.measures.end()) return fmt::format("{:.9g}", measure->second);
    return column == "name" ? row.name : "";
}

/// A row as the plot has it.
struct PlotPoint {
    std::string x, group;
    double y;
};

std::vector<PlotPoint> plot_points(const SweepFile& sweep, const std::vector<SweepRow>& rows) {
    const SweepPlot& plot = sweep.plot;
    const std::string column = measure_column(plot.y, plot.fit);
    // "true" alone would say nothing in a legend.
    const std::string key = plot.group.substr(plot.group.find('.') + 1) + " = ";
    std::vector<PlotPoint> points;
    for (const SweepRow& row : rows) {
        const auto y = row.measures.find(column);
        if (y == row.measures.end() || (plot.log_y && y->second <= 0)) continue;
        points.push_back({text_of(sweep, row, plot.x),
                          plot.group.empty() ? "" : key + text_of(sweep, row, plot.group),
                          y->second});
    }
    return points;
}

std::vector<std::string> distinct(const std::vector<PlotPoint>& points,
                                  std::string PlotPoint::*member) {
    std::vector<std::string> texts;
    for (const PlotPoint& point : points) {
        if (std::ranges::find(texts, point.*member) == texts.end()) texts.push_back(point.*member);
    }
    return texts;
}

std::string y_label(const SweepPlot& plot) {
    const bool is_fitted = measure_column(plot.y, plot.fit) != plot.y;
    return is_fitted ? fmt::format("{} ({} fit)", plot.y, plot.fit) : plot.y;
}

std::string lines(const SweepPlot& plot, const std::vector<PlotPoint>& points) {
    LinePlot picture{plot.title, plot.x, y_label(plot), AxisScale::linear, AxisScale::linear, {}};
    if (plot.log_x) picture.x_scale = AxisScale::logarithmic;
    if (plot.log_y) picture.y_scale = AxisScale::logarithmic;
    for (const std::string& group : distinct(points, &PlotPoint::group)) {
        std::vector<std::pair<double, double>> places;
        for (const PlotPoint& point : points) {
            const double x = *number_in(point.x);
            if (point.group == group && !(plot.log_x && x <= 0)) places.emplace_back(x, point.y);
        }
        std::ranges::stable_sort(places, {}, &std::pair<double, double>::first);
        LineSeries series{group, {}, {}};
        for (const auto& [x, y] : places) {
            series.x.push_back(x);
            series.y.push_back(y);
        }
        picture.series.push_back(std::move(series));
    }
    return line_plot_svg(picture);
}

std::string bars(const SweepPlot& plot, const std::vector<PlotPoint>& points) {
    BarPlot picture{
        plot.title, plot.x == "name" ? "" : plot.x, y_label(plot), AxisScale::linear, {}, {}};
    if (plot.log_y) picture.y_scale = AxisScale::logarithmic;
    picture.categories = distinct(points, &PlotPoint::x);
    for (const std::string& group : distinct(points, &PlotPoint::group)) {
        BarSeries series{group, {}};
        for (const std::string& x : picture.categories) {
            const auto point = std::ranges::find_if(
                points, [&](const PlotPoint& p) { return p.x == x && p.group == group; });
            series.values.push_back(point == points.end() ? std::nan("") : point->y);
        }
        picture.series.push_back(std::move(series));
    }
    return bar_plot_svg(picture);
}

}  // namespace

std::string plot_of(const SweepFile& sweep, const std::vector<SweepRow>& rows) {
    SweepFile named = sweep;
    std::vector<PlotPoint> points = plot_points(sweep, rows);
    const bool is_numeric = std::ranges::all_of(
        points, [](const PlotPoint& point) { return number_in(point.x).has_value(); });
    if (is_numeric && !points.empty()) return lines(sweep.plot, points);
    // Points that would hide each other stand apart under their names.
    const auto same = [&](const PlotPoint& a) {
        return std::ranges::count_if(points, [&](const PlotPoint& b) {
                   return a.x == b.x && a.group == b.group;
               }) > 1;
    };
    if (std::ranges::any_of(points, same)) {
        named.plot.x = "name";
        points = plot_points(named, rows);
    }
    return bars(named.plot, points);
}

}  // namespace mscomp
