// SPDX-License-Identifier: MIT
#include "mscomp/convert/array_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "base/temporary_folder.h"
#include "base/thrown_message.h"
#include "convert_cases.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/convert/npy.h"
#include "mscomp/convert/zip.h"

namespace mscomp {
namespace {

using namespace cases;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

template <class T>
std::string array(NpyType type, const Shape& shape, const std::vector<T>& values) {
    return npy_header(type, shape, sizeof(T)) +
           std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}
std::string doubles(const Shape& shape, double value = 0.5) {
    std::int64_t count = 1;
    for (const std::int64_t length : shape) count *= length;
    return array(NpyType::f64, shape, std::vector<double>(static_cast<std::size_t>(count), value));
}
std::string faces(const std::vector<std::int64_t>& corners) {
    return array(NpyType::i64, {static_cast<std::int64_t>(corners.size()) / 3, 3}, corners);
}

using Arrays = std::map<std::string, std::string>;

std::string put_npz(const TemporaryFolder& folder, const Arrays& arrays) {
    AtomicFile file(folder / "x.npz");
    ZipWriter zip(file);
    for (const auto& [name, bytes] : arrays) {
        zip.begin_file(name + ".npy");
        zip.write(std::string_view(bytes));
    }
    zip.finish();
    file.commit();
    return folder / "x.npz";
}

std::string refusal(const Arrays& arrays) {
    const TemporaryFolder folder;
    const std::string path = put_npz(folder, arrays);
    return thrown_message<InputError>([&] { read_npz(path, {}); });
}

Supplement square_reference() {
    Supplement supplement;
    supplement.reference_path = "square.obj";
    supplement.reference = shapes::grid(2, 2);
    return supplement;
}

TEST(ArrayFiles, ShapesComeBackBitForBit) {
    const TemporaryFolder folder;
    const MeshSequence spheres = stretched_spheres(3);
    std::vector<int> calls;
    write_npz(folder / "s.npz", SequenceSource(spheres), [&](int done) { calls.push_back(done); });
    EXPECT_THAT(calls, ElementsAre(1, 2, 3));
    const Contents contents = read_npz(folder / "s.npz", {});
    EXPECT_FALSE(contents.features);
    EXPECT_THAT(contents.notes, IsEmpty());
    expect_same(*contents.shapes, spheres);
    EXPECT_EQ(contents.shapes->names(), spheres.names);
}

TEST(ArrayFiles, AFeatureSetComesBackWhole) {
    const TemporaryFolder folder;
    write_npz(folder / "f.npz", full_set());
    const Contents contents = read_npz(folder / "f.npz", {});
    ASSERT_TRUE(contents.features);
    EXPECT_THAT(contents.notes, IsEmpty());
    expect_same(*contents.features, full_set());
}

TEST(ArrayFiles, APlainArrayTakesItsFacesFromTheReference) {
    const TemporaryFolder folder;
    MeshSequence grids;
    grids.faces = shapes::grid(2, 2).faces;
    grids.names = {"shape_0000", "shape_0001"};
    grids.shapes = {shapes::grid(2, 2).vertices, shapes::grid(2, 2).vertices};
    grids.shapes[1][3][2] = 1.0 / 3;
    write_npy(folder / "s.npy", SequenceSource(grids));
    const Contents contents = read_npy(folder / "s.npy", square_reference());
    EXPECT_TRUE(contents.took_reference);
    EXPECT_THAT(contents.notes, Contains(HasSubstr("faces are those of square.obj")));
    expect_same(*contents.shapes, grids);
    EXPECT_EQ(contents.shapes->names(), grids.names);
    EXPECT_THAT(thrown_message<UsageError>([&] { read_npy(folder / "s.npy", {}); }),
                HasSubstr("--reference"));
    Supplement other = square_reference();
    other.reference = shapes::grid(2, 3);
    EXPECT_THAT(thrown_message<InputError>([&] { read_npy(folder / "s.npy", other); }),
                HasSubstr("square.obj: 6 vertices, but"));
}

TEST(ArrayFiles, OtherProgramsNamesAndTypesAreRead) {
    const TemporaryFolder folder;
    const std::string path = put_npz(
        folder, {{"verts", array<float>(NpyType::f32, {1, 3, 3}, {0, 0, 0, 1, 0, 0, 0, 1, 2})},
                 {"tris", faces({0, 1, 2})},
                 {"mean", doubles({3})}});
    const Contents contents = read_npz(path, {});
    EXPECT_EQ(contents.shapes->faces(), std::vector<Face>({{0, 1, 2}}));
    EXPECT_EQ(contents.shapes->shape(0)[2], Point({0, 1, 2}));
    EXPECT_THAT(contents.shapes->names(), ElementsAre("shape_0000"));
    EXPECT_THAT(contents.notes, Contains(AllOf(HasSubstr("left out"), HasSubstr("mean"))));
}

// As MATLAB, scanners and networks have them: other names, types, orders of the axes, counting
// from 1.
TEST(ArrayFiles, ArraysAreTakenAsPeopleHaveThem) {
    const TemporaryFolder folder;
    const std::vector<double> points{0, 0, 0, 1, 0, 0, 0, 1, 2, 0, 0, 5};  // (1,4,3)
    const std::vector<double> transposed{0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 2, 5};
    const std::vector<std::int64_t> corners{0, 1, 2, 0, 2, 3};
    const auto expect_read = [&](const Arrays& arrays) {
        const Contents contents = read_npz(put_npz(folder, arrays), {});
        EXPECT_EQ(contents.shapes->faces(), std::vector<Face>({{0, 1, 2}, {0, 2, 3}}));
        EXPECT_EQ(contents.shapes->shape_count(), 1);
        EXPECT_EQ(contents.shapes->shape(0),
                  std::vector<Point>({{0, 0, 0}, {1, 0, 0}, {0, 1, 2}, {0, 0, 5}}));
        return contents.notes;
    };
    const auto vertices = [&](const Shape& shape) { return array(NpyType::f64, shape, points); };
    for (const char* name : {"vertices", "verts", "v", "V", "points", "pos", "positions"}) {
        expect_read({{name, vertices({1, 4, 3})}, {"faces", faces(corners)}});
    }
    for (const char* name : {"tris", "triangles", "F", "f", "cells", "Faces"}) {
        expect_read({{"verts", vertices({1, 4, 3})}, {name, faces(corners)}});
    }
    expect_read({{"arr_0", vertices({1, 4, 3})}, {"arr_1", faces(corners)}});
    // One shape, shapes as rows, coordinates first, shapes last.
    EXPECT_THAT(expect_read({{"v", vertices({4, 3})}, {"f", faces(corners)}}),
                Contains(HasSubstr("(4, 3) is read as (V,3)")));
    expect_read({{"v", vertices({1, 12})}, {"f", faces(corners)}});
    expect_read({{"v", vertices({4, 3, 1})}, {"f", faces(corners)}});
    expect_read({{"v", array(NpyType::f64, {3, 4}, transposed)}, {"f", faces(corners)}});
    expect_read({{"v", array(NpyType::f64, {1, 3, 4}, transposed)}, {"f", faces(corners)}});
    // Faces from 1, as doubles, with the corners first.
    EXPECT_THAT(expect_read({{"v", vertices({1, 4, 3})}, {"f", faces({1, 2, 3, 1, 3, 4})}}),
                Contains("faces are taken to count from 1"));
    expect_read({{"v", vertices({1, 4, 3})},
                 {"f", array<double>(NpyType::f64, {3, 2}, {0, 0, 1, 2, 2, 3})}});
    expect_read({{"v", vertices({1, 4, 3})},
                 {"f", array<std::uint32_t>(NpyType::u32, {2, 3}, {0, 1, 2, 0, 2, 3})}});
    expect_read({{"v", vertices({1, 4, 3})},
                 {"f", array<std::int16_t>(NpyType::i16, {2, 3}, {0, 1, 2, 0, 2, 3})}});
}

// Voxel grids and quantised scans: whole numbers, of any type and either byte order, are positions
// where the name or the file says that they are; what has neither name is not taken for them.
TEST(ArrayFiles, VerticesMayBeIntegers) {
    const TemporaryFolder folder;
    const std::vector<Point> wanted{{0, 0, 0}, {1000, 0, 0}, {0, 1000, -3}, {7, 8, 2000000000}};
    std::vector<std::int32_t> narrow;
    std::vector<std::int64_t> wide;
    for (const Point& p : wanted) {
        narrow.insert(narrow.end(), p.begin(), p.end());
        wide.insert(wide.end(), p.begin(), p.end());
    }
    const std::string as_narrow = array(NpyType::i32, {1, 4, 3}, narrow);
    for (const std::string& vertices : {as_narrow, array(NpyType::i64, {1, 4, 3}, wide)}) {
        const std::string corners = faces({0, 1, 2, 0, 2, 3});
        const std::string npz = put_npz(folder, {{"vertices", vertices}, {"faces", corners}});
        EXPECT_EQ(read_npz(npz, {}).shapes->shape(0), wanted);
        const std::string npy = folder.put("grid.npy", vertices);
        EXPECT_EQ(read_npy(npy, square_reference()).shapes->shape(0), wanted);
    }
    const std::string nameless =
        put_npz(folder, {{"arr_0", as_narrow}, {"arr_1", faces({0, 1, 2, 0, 2, 3})}});
    EXPECT_THAT(thrown_message<InputError>([&] { read_npz(nameless, {}); }),
                AllOf(HasSubstr("arr_0"), HasSubstr("<i4")));
}

TEST(ArrayFiles, RowsOfCoordinatesNeedTheVerticesOfTheReference) {
    const TemporaryFolder folder;
    const std::string rows = doubles({2, 12});
    const Contents contents = read_npy(folder.put("a.npy", rows), square_reference());
    EXPECT_EQ(contents.shapes->shape_count(), 2);
    EXPECT_EQ(contents.shapes->vertex_count(), 4);
    EXPECT_THAT(contents.notes, Contains(HasSubstr("(2, 12) is read as (N,V*3)")));
    EXPECT_THAT(thrown_message<UsageError>([&] { read_npy(folder.put("b.npy", rows), {}); }),
                HasSubstr("give a mesh that has them: --reference MESH"));
}

TEST(ArrayFiles, WhatCannotBeToldIsListed) {
    EXPECT_THAT(refusal({{"poses", doubles({5, 72})}, {"betas", npy_texts({"x"})}}),
                AllOf(HasSubstr("holds neither"), HasSubstr("'betas' <U1 (1,)"),
                      HasSubstr("'poses' <f8 (5, 72)")));
    EXPECT_THAT(refusal({{"a", doubles({2, 4, 3})}, {"b", doubles({2, 4, 3})}}),
                AllOf(HasSubstr("holds neither"), HasSubstr("'a' <f8 (2, 4, 3)")));
    EXPECT_THAT(refusal({{"v", doubles({1, 3, 3})}, {"V", doubles({1, 3, 3})}}),
                HasSubstr("holds both 'V' and 'v'"));
}

TEST(ArrayFiles, OtherKindsOfFilesAreNamed) {
    const TemporaryFolder folder;
    const std::string gzip("\x1f\x8b\x08\0\0\0\0\0", 8);
    for (const char* name : {"a.npz", "a.npy"}) {
        const std::string path = folder.put(name, gzip);
        const auto read = [&] {
            return path.ends_with("z") ? read_npz(path, {}) : read_npy(path, {});
        };
        EXPECT_THAT(thrown_message<InputError>([&] { read(); }),
                    HasSubstr("this is a gzip file: unpack it"));
    }
}

// The feature of the reference everywhere is the reference: r = 0, S = I.
TEST(ArrayFiles, FeaturesAloneAreCompletedFromTheReference) {
    const TemporaryFolder folder;
    FeatureSet set;
    set.names = {"a"};
    set.reference = shapes::grid(2, 2);
    for (int i = 0; i < 4; ++i) {
        set.features.insert(set.features.end(), kReferenceFeature.begin(), kReferenceFeature.end());
    }
    write_npy(folder / "f.npy", set);
    const Contents contents = read_npy(folder / "f.npy", square_reference());
    ASSERT_TRUE(contents.features);
    const FeatureSet& features = *contents.features;
    EXPECT_TRUE(same_bits(features.features, set.features));
    EXPECT_EQ(features.reference.faces, set.reference.faces);
    EXPECT_EQ(features.weights, "authors");
    EXPECT_THAT(contents.notes, Contains(HasSubstr("vertices are made from the features")));
    for (std::size_t i = 0; i < 12; ++i) {
        EXPECT_NEAR(features.vertices[i], set.reference.vertices[i / 3][i % 3], 1e-6);
    }
    EXPECT_THAT(thrown_message<UsageError>([&] { read_npy(folder / "f.npy", {}); }),
                HasSubstr("no reference and faces"));
}

TEST(ArrayFiles, VerticesThatShareAPlaceStillDoInANpz) {
    const TemporaryFolder folder;
    const std::string path = folder / "a.npz";
    const FeatureSet set = full_set();
    const std::vector<int> place{0, 1, 2, 0};
    write_npz(path, set, VertexPlaces::from_stored(place, set.reference.faces));
    EXPECT_EQ(read_npz(path, {}).features->places.place_of_vertex(), place);
    write_npz(path, set);
    EXPECT_TRUE(read_npz(path, {}).features->places.are_all_vertices());
}

TEST(ArrayFiles, RefusesArraysThatDoNotFitTogether) {
    EXPECT_THAT(refusal({{"verts", doubles({2, 3, 3})}, {"tris", faces({0, 1, 3})}}),
                AllOf(HasSubstr("x.npz[tris]"), HasSubstr("face 0 refers to vertex 3")));
    EXPECT_THAT(refusal({{"verts", doubles({2, 3, 3})}, {"tris", faces({0, 1, -1})}}),
                HasSubstr("vertex -1"));
    EXPECT_THAT(refusal({{"verts", doubles({2, 3, 3})}, {"tris", doubles({1, 3})}}),
                HasSubstr("no integers"));
    EXPECT_THAT(refusal({{"verts", doubles({2, 3, 3})}, {"tris", faces({})}}),
                HasSubstr("no faces"));
    EXPECT_THAT(refusal({{"verts", doubles({2, 3})}, {"tris", faces({0, 1, 2})}}),
                AllOf(HasSubstr("x.npz[verts]"), HasSubstr("(2, 3), wanted (any, any, 3)")));
    EXPECT_THAT(refusal({{"verts", doubles({0, 3, 3})}, {"tris", faces({0, 1, 2})}}),
                HasSubstr("0 shapes"));
    EXPECT_THAT(refusal({{"verts", faces({0, 1, 2})}, {"tris", faces({0, 1, 2})}}),
                HasSubstr("wanted (any, any, 3)"));
    EXPECT_THAT(refusal({{"verts", doubles({1, 3, 3})},
                         {"vertices", doubles({1, 3, 3})},
                         {"tris", faces({0, 1, 2})}}),
                HasSubstr("both 'vertices' and 'verts'"));
    EXPECT_THAT(refusal({{"tris", faces({0, 1, 2})}}), HasSubstr("neither"));
    EXPECT_THAT(refusal({{"verts", doubles({2, 3, 3})},
                         {"tris", faces({0, 1, 2})},
                         {"names", npy_texts({"only one"})}}),
                AllOf(HasSubstr("x.npz[names]"), HasSubstr("(1,), wanted (2)")));
}

TEST(ArrayFiles, RefusesFeatureSetsThatAreNotSound) {
    const Arrays sound{{"features", doubles({1, 3, 9})},
                       {"vertices", doubles({1, 3, 3})},
                       {"reference", doubles({3, 3})},
                       {"faces", faces({0, 1, 2})}};
    const auto with = [&](const std::string& name, const std::string& bytes) {
        Arrays arrays = sound;
        arrays[name] = bytes;
        return refusal(arrays);
    };
    EXPECT_THAT(with("features", doubles({1, 3, 8})), HasSubstr("wanted (any, any, 9)"));
    EXPECT_THAT(with("vertices", doubles({1, 4, 3})), HasSubstr("wanted (1, 3, 3)"));
    EXPECT_THAT(with("reference", doubles({3, 2})), HasSubstr("wanted (3, 3)"));
    EXPECT_THAT(with("faces", faces({0, 1, 7})), HasSubstr("vertex 7"));
    EXPECT_THAT(with("rotation", doubles({1, 3, 3})), HasSubstr("no rotation"));
    EXPECT_THAT(with("largest_jump", doubles({2})), HasSubstr("wanted (1)"));
    EXPECT_THAT(with("weights", npy_texts({"heavy"}, true)), HasSubstr("'heavy'"));
    EXPECT_THAT(with("features", doubles({1, 3, 9}, std::nan(""))), HasSubstr("[0, 0, 0] is nan"));
    EXPECT_THAT(with("features", doubles({1, 3, 9}, 1e200)), HasSubstr("float32"));
    EXPECT_THAT(with("largest_jump", doubles({1}, std::nan(""))), HasSubstr("is nan"));
    EXPECT_THAT(with("features", "no array"), HasSubstr("x.npz[features]: is not a numpy array"));
}

TEST(ArrayFiles, SixtyFourBitFeaturesAreRoundedAndThatIsSaid) {
    const TemporaryFolder folder;
    const std::string path = put_npz(folder, {{"features", doubles({1, 3, 9}, 0.1)},
                                              {"vertices", doubles({1, 3, 3}, 0.1)},
                                              {"reference", doubles({3, 3})},
                                              {"faces", faces({0, 1, 2})}});
    const Contents contents = read_npz(path, {});
    EXPECT_EQ(contents.features->features[0], 0.1F);
    EXPECT_THAT(contents.notes, Contains(HasSubstr("rounded to float32")));
}

TEST(ArrayFiles, AMissingFileIsAnIoError) {
    EXPECT_THROW(read_npz("nowhere.npz", {}), IoError);
    EXPECT_THROW(read_npy("nowhere.npy", {}), IoError);
}

TEST(ArrayFiles, NothingIsLeftOfAFileThatCannotBeFinished) {
    const TemporaryFolder folder;
    MeshSequence spheres = stretched_spheres(3);
    EXPECT_THROW(write_npz(folder / "a.npz", SequenceSource(spheres),
                           [](int done) {
                               if (done == 2) throw UsageError("stop");
                           }),
                 UsageError);
    spheres.shapes[2][1][0] = std::numeric_limits<double>::infinity();
    EXPECT_THROW(write_npz(folder / "a.npz", SequenceSource(spheres)), NumericalError);
    EXPECT_THROW(write_npy(folder / "a.npy", SequenceSource(spheres)), NumericalError);
    FeatureSet set = full_set();
    set.features[7] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THROW(write_npz(folder / "a.npz", set), NumericalError);
    EXPECT_THROW(write_npy(folder / "a.npy", set), NumericalError);
    EXPECT_THAT(folder.names(), IsEmpty());
}

}  // namespace
}  // namespace mscomp
