// SPDX-License-Identifier: MIT
#include "report/component_sides.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mscomp/acap/area_metric.h"
#include "mscomp/acap/mirrored_features.h"
#include "mscomp/base/random.h"
#include "mscomp/base/shape_features.h"
#include "shapes.h"

namespace mscomp {
namespace {

/// A long body with a plane of symmetry, and components around some of its vertices.
class Sides : public testing::Test {
  protected:
    Sides() {
        for (Point& p : mesh_.vertices) {
            p[2] *= 3;
            p[1] *= p[1] > 0 ? 1.6 : 1;  // no symmetry but left and right
            p[2] *= p[2] > 0 ? 1.3 : 1;
        }
        mirror_ = mirror_of(mesh_);
    }
    std::size_t vertices() const { return mesh_.vertices.size(); }
    /// Random where the distance from `place` is below 0.7.
    std::vector<float> around(const Point& place, std::uint64_t stream) const {
        const CounterRandom random(4, stream);
        std::vector<float> row(9 * vertices());
        for (std::size_t i = 0; i < row.size(); ++i) {
            const Point& p = mesh_.vertices[i / 9];
            const double away = std::hypot(p[0] - place[0], p[1] - place[1], p[2] - place[2]);
            if (away < 0.7) row[i] = static_cast<float>(1 + 0.2 * random.normal(i));
        }
        return row;
    }
    std::vector<float> mirrored(const std::vector<float>& row) const {
        const MemoryFeatures one(row, static_cast<int>(vertices()));
        const MirroredFeatures both(one, *mirror_);
        const auto image = both.shape(1);
        return {image.begin(), image.end()};
    }
    static Component component(const std::vector<float>& row) {
        Component c;
        c.difference = row;
        c.other_difference = row;
        for (float& x : c.other_difference) x *= -0.5F;
        return c;
    }

    TriangleMesh mesh_ = shapes::icosphere(3);
    std::optional<Mirror> mirror_;
};

TEST_F(Sides, ArePartnersWhereOneIsTheMirrorImageOfTheOther) {
    ASSERT_TRUE(mirror_);
    ASSERT_GT(std::abs(1 - mirror_->matrix(0, 0)), 1.9) << "across x";
    const auto right = around({-0.9, 0, 0.4}, 1), middle = around({0, 1.5, 0}, 2),
               far = around({0.7, 0, -2}, 3);
    const std::vector<Component> all{component(right), component(middle), component(far),
                                     component(mirrored(right))};
    const auto sides = component_sides(all, mesh_, *mirror_);
    EXPECT_EQ(sides[0].partner, 3);
    EXPECT_EQ(sides[3].partner, 0);
    EXPECT_EQ(sides[1].partner, -1) << "none is its own";
    EXPECT_EQ(sides[2].partner, -1);
    const Stance seen{{0, 1, 0}, {0, 0, 1}};  // left is +x
    EXPECT_EQ(side_name(sides[0], *mirror_, seen), "right");
    EXPECT_EQ(side_name(sides[3], *mirror_, seen), "left");
    EXPECT_EQ(side_name(sides[2], *mirror_, seen), "left");
    EXPECT_EQ(side_name(sides[1], *mirror_, seen), "middle");
    const Stance from_behind{{0, 1, 0}, {0, 0, -1}};
    EXPECT_EQ(side_name(sides[0], *mirror_, from_behind), "left");
    const Stance flank{{0, 1, 0}, {1, 0, 0}};
    EXPECT_EQ(side_name(sides[0], *mirror_, flank), "");
}

// The image of a displacement d at p is M d at the reflected p.
TEST_F(Sides, OfDisplacementsAreThoseOfTheirVectors) {
    ASSERT_TRUE(mirror_);
    const auto field = [&](const Point& place, const Eigen::Vector3d& way) {
        std::vector<float> row;
        for (const Point& p : mesh_.vertices) {
            const double away = std::hypot(p[0] - place[0], p[1] - place[1], p[2] - place[2]);
            for (const double x : way) row.push_back(static_cast<float>(x * std::exp(-4 * away)));
        }
        return row;
    };
    const Point right{-0.9, 0, 0.4}, left = mirror_->reflected(right);
    const Eigen::Vector3d way(1, 1, 0.5);
    const std::vector<Component> all{component(field(right, way)), component(field(left, way)),
                                     component(field(left, mirror_->matrix * way))};
    const auto sides = component_sides(all, mesh_, *mirror_);
    EXPECT_EQ(sides[0].partner, 2) << "not the one that goes the same way";
    EXPECT_EQ(sides[2].partner, 0);
    EXPECT_EQ(sides[1].partner, -1);
    const Stance seen{{0, 1, 0}, {0, 0, 1}};
    EXPECT_EQ(side_name(sides[0], *mirror_, seen), "right");
    EXPECT_EQ(side_name(sides[2], *mirror_, seen), "left");
}

TEST_F(Sides, WhatDoesNothingIsNowhere) {
    const std::vector<float> nothing(9 * vertices());
    const std::vector<Component> all{component(nothing), component(nothing)};
    const auto sides = component_sides(all, mesh_, *mirror_);
    EXPECT_EQ(side_name(sides[0], *mirror_, {}), "");
    EXPECT_EQ(sides[0].partner, -1);
    EXPECT_EQ(way_of_acting(nothing, area_metric(mesh_)), "");
}

// Another that looks less like the image has none: the image has its partner already.
TEST_F(Sides, ThirdsAreNoPartners) {
    const auto right = around({-0.9, 0, 0.4}, 1), left = mirrored(right);
    std::vector<float> less = left;
    for (std::size_t i = 0; i < less.size(); i += 4) less[i] = 0;
    const std::vector<Component> all{component(right), component(left), component(less)};
    const auto sides = component_sides(all, mesh_, *mirror_);
    EXPECT_EQ(sides[0].partner, 1);
    EXPECT_EQ(sides[2].partner, -1);
}

// The mirror image of a turn is the turn the other way: ends may be either.
TEST_F(Sides, EitherEndMayBeTheImage) {
    const auto right = around({-0.9, 0, 0.4}, 1);
    Component image = component(mirrored(right));
    std::swap(image.difference, image.other_difference);
    std::ranges::fill(image.other_difference, 0.0F);
    Component still = component(right);
    std::ranges::fill(still.other_difference, 0.0F);
    const std::vector<Component> all{still, image};
    EXPECT_EQ(component_sides(all, mesh_, *mirror_)[0].partner, 1);
}

TEST_F(Sides, TurnsAndStretchesAreToldApart) {
    const std::vector<float> roots = area_metric(mesh_);
    const auto acting = [&](float turn, float stretch) {
        std::vector<float> row(9 * vertices());
        for (std::size_t i = 0; i < row.size(); ++i) row[i] = i % 9 < 3 ? turn : stretch;
        return way_of_acting(row, roots);
    };
    EXPECT_EQ(acting(1, 0.1F), "turns");
    EXPECT_EQ(acting(0.1F, 1), "stretches");
    EXPECT_EQ(acting(1, 0.6F), "both");  // 3 to 9 · 0.36
    EXPECT_EQ(acting(1, 0.3F),
              "both");  // entries beside the diagonal are there twice: 3 to 9 · 0.09
}

}  // namespace
}  // namespace mscomp
