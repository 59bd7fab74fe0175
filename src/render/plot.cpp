// SPDX-License-Identifier: MIT
#include "mscomp/render/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

// Pixels.
constexpr double kWidth = 760, kHeight = 460;
constexpr double kLeft = 84, kRight = 24, kTop = 48;
constexpr double kBottom = 64, kLegendRow = 20;
constexpr double kCharacter = 6.6;  // mean width in the font used, for what must not overlap
constexpr int kMostTicks = 8;

/// Colours that the colour-blind can tell apart (Okabe and Ito).
constexpr std::array<const char*, 7> kColors{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                             "#e69f00", "#56b4e9", "#333333"};
const char* color(std::size_t series) { return kColors[series % kColors.size()]; }

std::string escaped(std::string_view text) {
    std::string result;
    for (const char c : text) {
        const auto code = static_cast<unsigned char>(c);
        if (c == '&') {
            result += "&amp;";
        } else if (c == '<') {
            result += "&lt;";
        } else if (c == '>') {
            result += "&gt;";
        } else if (c == '"') {
            result += "&quot;";
        } else {
            result += code < 0x20 || code == 0x7f ? '?' : c;
        }
    }
    return result;
}

struct Range {
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();

    void include(double value) {
        low = std::min(low, value);
        high = std::max(high, value);
    }
    bool is_empty() const { return low > high; }
};

/// Numbers to pixels; the ticks at both ends are the ends of the axis.
class Axis {
  public:
    Axis(Range range, AxisScale scale, double from, double to)
        : scale_(scale), from_(from), to_(to) {
        if (range.is_empty()) range = {1, 10};
        ticks_ = scale == AxisScale::linear ? round_ticks(range.low, range.high, kMostTicks)
                                            : log_ticks(range.low, range.high, kMostTicks);
    }
    double pixel(double value) const {
        const double low = place(ticks_.front()), high = place(ticks_.back());
        return from_ + (to_ - from_) * (place(value) - low) / (high - low);
    }
    const std::vector<double>& ticks() const { return ticks_; }

  private:
    double place(double value) const {
        return scale_ == AxisScale::linear ? value : std::log10(value);
    }

    AxisScale scale_;
    double from_, to_;
    std::vector<double> ticks_;
};

/// The document line by line.
class Drawing {
  public:
    explicit Drawing(double height) {
        text_ = fmt::format(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:g}\" height=\"{1:g}\" "
            "viewBox=\"0 0 {0:g} {1:g}\" font-family=\"sans-serif\" font-size=\"12\" "
            "fill=\"#333333\">\n<rect width=\"{0:g}\" height=\"{1:g}\" fill=\"white\"/>\n",
            kWidth, height);
    }
    void text(double x, double y, std::string_view anchor, std::string_view content,
              std::string_view more = "") {
        if (content.empty()) return;
        text_ += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x,
                             y, anchor, more, escaped(content));
    }
    void line(double x1, double y1, double x2, double y2, std::string_view stroke) {
        text_ += fmt::format(
            "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\"/>\n", x1,
            y1, x2, y2, stroke);
    }
    void add(const std::string& element) { text_ += element; }
    std::string finish() && { return std::move(text_) + "</svg>\n"; }

  private:
    std::string text_;
};

constexpr double kPlotRight = kWidth - kRight, kPlotBottom = kHeight - kBottom;

template <class Series>
double height_with_legend(const std::vector<Series>& series) {
    const bool has_legend =
        std::ranges::any_of(series, [](const Series& s) { return !s.label.empty(); });
    return kHeight + (has_legend ? kLegendRow * static_cast<double>(series.size()) : 0);
}

template <class Series>
void draw_legend(Drawing& drawing, const std::vector<Series>& series, double room = 0) {
    if (height_with_legend(series) == kHeight) return;
    for (std::size_t i = 0; i < series.size(); ++i) {
        const double y = kHeight + room + kLegendRow * static_cast<double>(i);
        drawing.add(
            fmt::format("<rect class=\"key\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"14\" height=\"10\" "
                        "fill=\"{}\"/>\n",
                        kLeft, y - 10, color(i)));
        drawing.text(kLeft + 20, y, "start", series[i].label);
    }
}

struct Labels {
    const std::string &title, &x, &y;
};

/// `room`: how much more the names along x need.
void draw_frame(Drawing& drawing, const Axis& y, const Labels& labels, double room = 0) {
    for (const double tick : y.ticks()) {
        drawing.line(kLeft, y.pixel(tick), kPlotRight, y.pixel(tick), "#dddddd");
        drawing.text(kLeft - 8, y.pixel(tick) + 4, "end", fmt::format("{:.10g}", tick),
                     " class=\"tick-y\"");
    }
    drawing.line(kLeft, kTop, kLeft, kPlotBottom, "#333333");
    drawing.line(kLeft, kPlotBottom, kPlotRight, kPlotBottom, "#333333");
    drawing.text((kLeft + kPlotRight) / 2, 26, "middle", labels.title, " font-size=\"15\"");
    drawing.text((kLeft + kPlotRight) / 2, kPlotBottom + 42 + room, "middle", labels.x);
    const double middle = (kTop + kPlotBottom) / 2;
    drawing.text(20, middle, "middle", labels.y,
                 fmt::format(" transform=\"rotate(-90 20 {:.1f})\"", middle));
}

void draw_series(Drawing& drawing, const LineSeries& series, const char* stroke, const Axis& x,
                 const Axis& y) {
    std::string path, markers;
    for (std::size_t i = 0; i < series.x.size(); ++i) {
        if (!std::isfinite(series.x[i]) || !std::isfinite(series.y[i])) continue;
        const double px = x.pixel(series.x[i]), py = y.pixel(series.y[i]);
        path += fmt::format("{}{:.1f},{:.1f}", path.empty() ? "" : " ", px, py);
        markers += fmt::format(
            "<circle class=\"marker\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" "
            "fill=\"{}\"><title>{}{:.6g}, "
            "{:.6g}</title></circle>\n",
            px, py, stroke, escaped(series.label.empty() ? "" : series.label + ": "), series.x[i],
            series.y[i]);
    }
    if (path.empty()) return;
    drawing.add(
        fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\"/>\n",
                    path, stroke));
    drawing.add(markers);
}

/// Width that a name takes up, and the room below the axis for names that stand upright.
double text_width(const std::string& name) { return kCharacter * static_cast<double>(name.size()); }

double longest_width(const std::vector<std::string>& names) {
    double longest = 0;
    for (const std::string& name : names) longest = std::max(longest, text_width(name));
    return longest;
}

/// Names below the axis, upright where they would run into each other.
void draw_categories(Drawing& drawing, const std::vector<std::string>& names, double slot,
                     bool upright) {
    for (std::size_t c = 0; c < names.size(); ++c) {
        const double x = kLeft + slot * (static_cast<double>(c) + 0.5);
        if (upright) {
            drawing.text(
                x + 4, kPlotBottom + 10, "end", names[c],
                fmt::format(" transform=\"rotate(-90 {:.1f} {:.1f})\"", x + 4, kPlotBottom + 10));
        } else {
            drawing.text(x, kPlotBottom + 20, "middle", names[c]);
        }
    }
}

void draw_bar(Drawing& drawing, double x, double width, double from, double to, const char* fill,
              const std::string& title) {
    drawing.add(
        fmt::format("<rect class=\"bar\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" "
                    "height=\"{:.1f}\" fill=\"{}\"><title>{}</title></rect>\n",
                    x, std::min(from, to), width, std::abs(to - from), fill, escaped(title)));
}

void draw_bars(Drawing& drawing, const BarPlot& plot, const Axis& y, double slot) {
    const double base = plot.y_scale == AxisScale::linear ? y.pixel(0) : kPlotBottom;
    const double width = 0.8 * slot / static_cast<double>(plot.series.size());
    for (std::size_t s = 0; s < plot.series.size(); ++s) {
        const BarSeries& series = plot.series[s];
        for (std::size_t c = 0; c < plot.categories.size(); ++c) {
            if (!std::isfinite(series.values[c])) continue;
            const double left =
                kLeft + slot * (static_cast<double>(c) + 0.1) + width * static_cast<double>(s);
            const std::string& name = plot.categories[c];
            draw_bar(
                drawing, left, width, base, y.pixel(series.values[c]), color(s),
                fmt::format("{}: {:.6g}", series.label.empty() ? name : name + ", " + series.label,
                            series.values[c]));
        }
    }
}

}  // namespace

std::string line_plot_svg(const LinePlot& plot) {
    Range x_range, y_range;
    for (const LineSeries& series : plot.series) {
        if (series.x.size() != series.y.size()) {
            throw UsageError(fmt::format("plot: {} numbers along x, {} along y", series.x.size(),
                                         series.y.size()));
        }
        for (std::size_t i = 0; i < series.x.size(); ++i) {
            if (!std::isfinite(series.x[i]) || !std::isfinite(series.y[i])) continue;
            x_range.include(series.x[i]);
            y_range.include(series.y[i]);
        }
    }
    const Axis x(x_range, plot.x_scale, kLeft, kPlotRight);
    const Axis y(y_range, plot.y_scale, kPlotBottom, kTop);
    Drawing drawing(height_with_legend(plot.series));
    draw_frame(drawing, y, {plot.title, plot.x_label, plot.y_label});
    for (const double tick : x.ticks()) {
        drawing.line(x.pixel(tick), kPlotBottom, x.pixel(tick), kPlotBottom + 5, "#333333");
        drawing.text(x.pixel(tick), kPlotBottom + 20, "middle", fmt::format("{:.10g}", tick),
                     " class=\"tick-x\"");
    }
    for (std::size_t s = 0; s < plot.series.size(); ++s) {
        draw_series(drawing, plot.series[s], color(s), x, y);
    }
    draw_legend(drawing, plot.series);
    return std::move(drawing).finish();
}

std::string bar_plot_svg(const BarPlot& plot) {
    Range range;
    for (const BarSeries& series : plot.series) {
        if (series.values.size() != plot.categories.size()) {
            throw UsageError(fmt::format("plot: {} bars for {} categories", series.values.size(),
                                         plot.categories.size()));
        }
        for (const double value : series.values) {
            if (!std::isfinite(value)) continue;
            range.include(value);
            if (plot.y_scale == AxisScale::linear) range.include(0);
        }
    }
    const Axis y(range, plot.y_scale, kPlotBottom, kTop);
    const auto slots = static_cast<double>(std::max<std::size_t>(plot.categories.size(), 1));
    const double slot = (kPlotRight - kLeft) / slots;
    const double longest = longest_width(plot.categories);
    const bool upright = longest > slot;
    const double room = upright ? longest : 0;
    Drawing drawing(height_with_legend(plot.series) + room);
    draw_frame(drawing, y, {plot.title, plot.x_label, plot.y_label}, room);
    draw_categories(drawing, plot.categories, slot, upright);
    draw_bars(drawing, plot, y, slot);
    draw_legend(drawing, plot.series, room);
    return std::move(drawing).finish();
}

}  // namespace mscomp
