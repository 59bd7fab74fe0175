// SPDX-License-Identifier: MIT
#include "mscomp/base/vertex_places.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <span>

#include "mscomp/base/error.h"
#include "thrown_message.h"

namespace mscomp {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Vertex 3 lies on 1, vertex 2 is in no face.
VertexPlaces five_vertices() { return {{0, 1, 2, 1, 4}, {{0, 1, 4}, {0, 3, 4}}}; }

TEST(VertexPlaces, EveryVertexIsAPlaceByDefault) {
    for (const VertexPlaces& places : {VertexPlaces(), VertexPlaces({0, 1, 2}, {{0, 1, 2}})}) {
        EXPECT_TRUE(places.are_all_vertices());
        EXPECT_TRUE(places.place_of_vertex().empty());
        EXPECT_EQ(places.place(2), 2);
        EXPECT_EQ(places.vertex(2), 2);
        EXPECT_EQ(places.coincident_count() + places.unused_count(), 0);
        EXPECT_EQ(places.place_count(3), 3);
    }
}

TEST(VertexPlaces, CoincidentVerticesShareOneAndUnusedOnesHaveNone) {
    const VertexPlaces places = five_vertices();
    EXPECT_FALSE(places.are_all_vertices());
    EXPECT_THAT(places.place_of_vertex(), ElementsAre(0, 1, -1, 1, 2));
    EXPECT_EQ(places.vertex(1), 1);
    EXPECT_EQ(places.vertex(2), 4);
    EXPECT_EQ(places.coincident_count(), 1);
    EXPECT_EQ(places.unused_count(), 1);
    EXPECT_EQ(places.place_count(5), 3);
}

TEST(VertexPlaces, RowsGoToThePlacesAndBack) {
    const VertexPlaces places = five_vertices();
    const std::vector<int> rows{0, 1, 10, 11, 20, 21, 30, 31, 40, 41};
    const std::vector<int> of_places = places.of_places(std::span(rows), 2);
    EXPECT_THAT(of_places, ElementsAre(0, 1, 10, 11, 40, 41));
    std::vector<int> back = rows;
    places.to_vertices(std::span(of_places), std::span(back), 2);
    EXPECT_THAT(back, ElementsAre(0, 1, 10, 11, 20, 21, 10, 11, 40, 41));
}

TEST(VertexPlaces, TheSurfaceHasAllFaces) {
    const TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {9, 9, 9}, {1, 0, 0}, {0, 1, 0}},
                            {{0, 1, 4}, {0, 3, 4}}};
    const TriangleMesh surface = five_vertices().surface(mesh);
    EXPECT_EQ(surface.vertices, (std::vector<Point>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_EQ(surface.faces, (std::vector<Face>{{0, 1, 2}, {0, 1, 2}}));
}

TEST(VertexPlaces, AreStoredAsNumbersAndChecked) {
    const std::vector<Face> faces{{0, 1, 4}, {0, 3, 4}};
    const VertexPlaces places = VertexPlaces::from_stored({0, 1, -1, 1, 2}, faces);
    EXPECT_EQ(places.place_of_vertex(), five_vertices().place_of_vertex());
    EXPECT_EQ(places.vertex(2), 4);
    const auto refused = [&](std::vector<int> place) {
        return thrown_message<MeshError>([&] { VertexPlaces::from_stored(place, faces); });
    };
    EXPECT_THAT(refused({0, 2, -1, 1, 2}), HasSubstr("place[1] is 2, wanted -1 to 1"));
    EXPECT_THAT(refused({0, -2, -1, 1, 2}), HasSubstr("place[1] is -2"));
    EXPECT_THAT(refused({0, 1, 2, -1, 3}), HasSubstr("faces[1] uses vertex 3, whose place is -1"));
}

}  // namespace
}  // namespace mscomp
