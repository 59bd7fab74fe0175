// SPDX-License-Identifier: MIT
#include "mscomp/render/plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <regex>
#include <string>
#include <vector>

#include "mscomp/base/error.h"
#include "mscomp/base/random.h"

namespace mscomp {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

/// An element of a document: its name, its attributes and the text behind its tag.
struct Element {
    std::string name, attributes, text;
    std::string operator[](const std::string& attribute) const {
        std::smatch found;
        const std::regex pattern("\\b" + attribute + "=\"([^\"]*)\"");
        return std::regex_search(attributes, found, pattern) ? found[1].str() : "";
    }
};

/// Elements in the order of their tags; fails where tags do not match or text is not escaped.
std::vector<Element> parsed(const std::string& xml) {
    static const std::regex kTag(
        "<(/?)([a-z]+)((?: [a-zA-Z0-9-]+=\"[^\"<&]*(?:&(?:amp|lt|gt|quot);[^\"<&]*)*\")*)(/?)>"
        "([^<>&]*(?:&(?:amp|lt|gt|quot);[^<>&]*)*)");
    std::vector<Element> elements;
    std::vector<std::string> open;
    std::string rest = xml;
    std::smatch tag;
    while (std::regex_search(rest, tag, kTag, std::regex_constants::match_continuous)) {
        if (tag[1].length() > 0) {
            EXPECT_FALSE(open.empty());
            if (open.empty() || open.back() != tag[2]) ADD_FAILURE() << "</" << tag[2] << ">";
            open.pop_back();
        } else {
            elements.push_back({tag[2], tag[3], tag[5]});
            if (tag[4].length() == 0) open.push_back(tag[2]);
        }
        rest = tag.suffix();
    }
    EXPECT_EQ(rest, "") << "not XML";
    EXPECT_TRUE(open.empty());
    return elements;
}

std::vector<Element> of_class(const std::string& svg, const std::string& name) {
    std::vector<Element> found;
    for (const Element& element : parsed(svg)) {
        if (element["class"] == name) found.push_back(element);
    }
    return found;
}

LinePlot three_and_two() {
    return {"error",
            "components",
            "rms",
            AxisScale::linear,
            AxisScale::linear,
            {{"horse", {10, 20, 50}, {9, 7, 4}}, {"scape", {10, 50}, {12, 6}}}};
}

double number(const std::string& text) { return std::stod(text); }

TEST(Ticks, AreRoundAndCover) {
    EXPECT_THAT(round_ticks(0, 10, 6), ElementsAre(0, 2, 4, 6, 8, 10));
    EXPECT_THAT(round_ticks(0.31, 0.58, 5), ElementsAre(0.3, 0.4, 0.5, 0.6));
    EXPECT_THAT(round_ticks(-3, 4, 5), ElementsAre(-4, -2, 0, 2, 4));
    EXPECT_THAT(log_ticks(3, 40, 8), ElementsAre(2, 5, 10, 20, 50));
    EXPECT_THAT(log_ticks(0.02, 3000, 8), ElementsAre(0.01, 0.1, 1, 10, 100, 1000, 10000));
}

// Of any range: the ends lie within the ticks, no tick could be left out at an end, neighbours are
// 1, 2 or 5 times a power of ten apart, and there are not too many.
TEST(Ticks, OfAnyRangeAreFewRoundAndTight) {
    const CounterRandom random(7, 0);
    for (std::uint64_t i = 0; i < 2000; ++i) {
        const double scale = std::pow(10, 8 * random.normal(3 * i));
        const double low = scale * random.normal(3 * i + 1);
        const double high = low + std::abs(scale * random.normal(3 * i + 2));
        const std::vector<double> ticks = round_ticks(low, high, 8);
        ASSERT_LE(ticks.size(), 8u);
        ASSERT_GE(ticks.size(), 2u);
        const double slack = 1e-12 * (std::abs(low) + std::abs(high));
        EXPECT_TRUE(ticks.front() <= low + slack && low <= ticks[1] + slack);
        EXPECT_TRUE(ticks.back() >= high - slack && high >= ticks[ticks.size() - 2] - slack);
        const double step = (ticks.back() - ticks.front()) / static_cast<double>(ticks.size() - 1);
        const double mantissa = step / std::pow(10, std::floor(std::log10(step) + 1e-9));
        const bool is_round = std::abs(mantissa - 1) < 1e-6 || std::abs(mantissa - 2) < 1e-6 ||
                              std::abs(mantissa - 5) < 1e-6;
        EXPECT_TRUE(is_round) << low << " " << high << " " << step;
    }
}

TEST(Ticks, OfOneValueAreAroundIt) {
    for (const double value : {0.0, 3.0, -0.2, 1e9}) {
        const std::vector<double> ticks = round_ticks(value, value, 8);
        EXPECT_LT(ticks.front(), value);
        EXPECT_GT(ticks.back(), value);
    }
    EXPECT_LT(log_ticks(3, 3, 8).front(), 3);
    EXPECT_GT(log_ticks(3, 3, 8).back(), 3);
}

TEST(Ticks, RefuseWhatHasNoAxis) {
    EXPECT_THROW(round_ticks(0, kNothing, 8), UsageError);
    EXPECT_THROW(round_ticks(1, 0, 8), UsageError);
    EXPECT_THROW(log_ticks(0, 1, 8), UsageError);
}

TEST(LinePlotSvg, HasAMarkerForEveryPointAndALineForEverySeries) {
    const std::string svg = line_plot_svg(three_and_two());
    EXPECT_EQ(of_class(svg, "marker").size(), 5u);
    int lines = 0;
    for (const Element& element : parsed(svg)) lines += element.name == "polyline";
    EXPECT_EQ(lines, 2);
    EXPECT_EQ(of_class(svg, "key").size(), 2u);
}

// The pixel of a marker, read back between the two ticks around it, is its number.
TEST(LinePlotSvg, PutsMarkersWhereTheTicksSay) {
    for (const AxisScale scale : {AxisScale::linear, AxisScale::logarithmic}) {
        LinePlot plot = three_and_two();
        plot.x_scale = plot.y_scale = scale;
        const std::string svg = line_plot_svg(plot);
        const auto place = [scale](double v) {
            return scale == AxisScale::linear ? v : std::log10(v);
        };
        const auto read = [&](const std::string& ticks, const std::string& axis, double pixel,
                              double below) {
            const std::vector<Element> all = of_class(svg, ticks);
            const double p0 = number(all.front()[axis]) - below;
            const double p1 = number(all.back()[axis]) - below;
            const double v0 = place(number(all.front().text)), v1 = place(number(all.back().text));
            return v0 + (v1 - v0) * (pixel - p0) / (p1 - p0);
        };
        const std::vector<Element> markers = of_class(svg, "marker");
        ASSERT_EQ(markers.size(), 5u);
        const std::vector<double> x{10, 20, 50, 10, 50}, y{9, 7, 4, 12, 6};
        for (std::size_t i = 0; i < markers.size(); ++i) {
            // Labels stand 4 pixels below their tick; a tenth of a pixel is the rounding.
            EXPECT_NEAR(read("tick-x", "x", number(markers[i]["cx"]), 0), place(x[i]), 0.02);
            EXPECT_NEAR(read("tick-y", "y", number(markers[i]["cy"]), 4), place(y[i]), 0.02);
        }
    }
}

TEST(LinePlotSvg, LeavesOutWhatIsNotFinite) {
    LinePlot plot = three_and_two();
    plot.series[0].y[1] = kNothing;
    plot.series[1].y = {kNothing, kNothing};
    const std::string svg = line_plot_svg(plot);
    EXPECT_EQ(of_class(svg, "marker").size(), 2u);
    EXPECT_THAT(svg, testing::Not(HasSubstr("nan")));
}

TEST(LinePlotSvg, EscapesText) {
    LinePlot plot = three_and_two();
    plot.title = "a < b & \"c\"\n";
    plot.series[0].label = "<script>";
    const std::string svg = line_plot_svg(plot);
    parsed(svg);
    EXPECT_THAT(svg, HasSubstr("a &lt; b &amp; &quot;c&quot;?"));
}

TEST(LinePlotSvg, OfNothingIsStillAPicture) {
    parsed(line_plot_svg({}));
    parsed(bar_plot_svg({}));
}

TEST(LinePlotSvg, RefusesSizesThatDifferAndLogarithmsOfZero) {
    LinePlot plot = three_and_two();
    plot.series[0].y.pop_back();
    EXPECT_THROW(line_plot_svg(plot), UsageError);
    plot = three_and_two();
    plot.series[0].y[0] = 0;
    plot.y_scale = AxisScale::logarithmic;
    EXPECT_THROW(line_plot_svg(plot), UsageError);
}

// Heights are as the numbers, below zero too: bars begin at 0.
TEST(BarPlotSvg, HasBarsAsHighAsTheNumbers) {
    const BarPlot plot{"t",
                       "x",
                       "y",
                       AxisScale::linear,
                       {"one", "two", "three"},
                       {{"a", {1, -2, 4}}, {"b", {3, kNothing, 2}}}};
    const std::vector<Element> bars = of_class(bar_plot_svg(plot), "bar");
    ASSERT_EQ(bars.size(), 5u);
    const double unit = number(bars[0]["height"]);
    const std::vector<double> expected{1, 2, 4, 3, 2};
    for (std::size_t i = 0; i < bars.size(); ++i) {
        EXPECT_NEAR(number(bars[i]["height"]), expected[i] * unit, 0.3);
    }
    const double zero = number(bars[0]["y"]) + unit;
    EXPECT_NEAR(number(bars[1]["y"]), zero, 0.2);
    EXPECT_NEAR(number(bars[2]["y"]) + number(bars[2]["height"]), zero, 0.2);
}

TEST(BarPlotSvg, KeepsBarsOfACategoryTogetherAndInOrder) {
    const BarPlot plot{"",
                       "",
                       "",
                       AxisScale::logarithmic,
                       {std::string(60, 'n'), "two"},
                       {{"a", {10, 20}}, {"b", {30, 40}}}};
    const std::vector<Element> bars = of_class(bar_plot_svg(plot), "bar");
    ASSERT_EQ(bars.size(), 4u);
    const auto left = [&](std::size_t i) { return number(bars[i]["x"]); };
    EXPECT_LT(left(0), left(2));  // a, b of the first category
    EXPECT_LT(left(2), left(1));
    EXPECT_LT(left(1), left(3));
}

}  // namespace
}  // namespace mscomp
