// SPDX-License-Identifier: MIT
#include "mscomp/convert/splocs_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/full_disk.h"
#include "base/temporary_folder.h"
#include "base/thrown_message.h"
#include "convert_cases.h"
#include "mscomp/base/error.h"

#ifdef MSCOMP_HAS_HDF5
#include <hdf5.h>
#endif

namespace mscomp {
namespace {

using namespace cases;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

#ifdef MSCOMP_HAS_HDF5

/// Writes one data set with HDF5 itself; gzip in chunks of several shapes where `chunk` is given.
void put(const std::string& path, const char* name, hid_t type, std::vector<hsize_t> lengths,
         hid_t memory_type, const void* data, std::vector<hsize_t> chunk = {}) {
    const bool exists = H5Fis_hdf5(path.c_str()) > 0;
    const hid_t file = exists ? H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT)
                              : H5Fcreate(path.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t space = H5Screate_simple(static_cast<int>(lengths.size()), lengths.data(), nullptr);
    const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
    if (!chunk.empty()) {
        H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data());
        H5Pset_deflate(properties, 4);
    }
    const hid_t dataset = H5Dcreate2(file, name, type, space, H5P_DEFAULT, properties, H5P_DEFAULT);
    ASSERT_GE(H5Dwrite(dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), 0);
    H5Dclose(dataset);
    H5Pclose(properties);
    H5Sclose(space);
    H5Fclose(file);
}

class SplocsFile : public testing::Test {
  protected:
    SplocsFile() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

    void put_verts(const MeshSequence& sequence, hid_t type, std::vector<hsize_t> chunk = {}) {
        std::vector<double> numbers;
        for (const auto& shape : sequence.shapes) {
            for (const Point& p : shape) numbers.insert(numbers.end(), p.begin(), p.end());
        }
        const hsize_t count = sequence.shapes.size(), vertices = sequence.shapes[0].size();
        put(path_, "verts", type, {count, vertices, 3}, H5T_NATIVE_DOUBLE, numbers.data(),
            std::move(chunk));
    }
    void put_tris(const std::vector<Face>& faces, hid_t type) {
        put(path_, "tris", type, {faces.size(), 3}, H5T_NATIVE_INT, faces.data());
    }
    std::string refusal() const {
        return thrown_message<InputError>([&] { read_splocs(path_); });
    }

    TemporaryFolder folder_;
    std::string path_ = folder_ / "x.h5";
    MeshSequence spheres_ = stretched_spheres(5);
};

TEST_F(SplocsFile, ShapesComeBackBitForBit) {
    std::vector<int> calls;
    write_splocs(path_, SequenceSource(spheres_), [&](int done) { calls.push_back(done); });
    EXPECT_THAT(calls, ElementsAre(1, 2, 3, 4, 5));
    const Contents contents = read_splocs(path_);
    expect_same(*contents.shapes, spheres_);
    EXPECT_EQ(contents.shapes->names().back(), "shape_0004");
    EXPECT_THAT(folder_.names(), ElementsAre("x.h5"));
    write_splocs(folder_ / "y.h5", SequenceSource(spheres_));
    EXPECT_EQ(TemporaryFolder::content(path_), TemporaryFolder::content(folder_ / "y.h5"));
}

// As other programs write them: packed in chunks that cross the shapes, integers of any size.
TEST_F(SplocsFile, PackedChunksAndOtherTypesAreRead) {
    put_verts(spheres_, H5T_IEEE_F64BE, {2, 7, 2});
    put_tris(spheres_.faces, H5T_STD_U16LE);
    const double scale = 2;
    put(path_, "scale", H5T_IEEE_F64LE, {1}, H5T_NATIVE_DOUBLE, &scale);
    expect_same(*read_splocs(path_).shapes, spheres_);
}

TEST_F(SplocsFile, FloatsAreRead) {
    put_verts(spheres_, H5T_IEEE_F32LE);
    put_tris(spheres_.faces, H5T_STD_I64LE);
    for (auto& shape : spheres_.shapes) {
        for (Point& p : shape) {
            for (double& x : p) x = static_cast<double>(static_cast<float>(x));
        }
    }
    expect_same(*read_splocs(path_).shapes, spheres_);
}

TEST_F(SplocsFile, RefusesOtherFiles) {
    EXPECT_THROW(read_splocs(path_), IoError);
    EXPECT_THROW(read_splocs(folder_.path()), IoError);
    folder_.put("x.h5", "no HDF5 at all");
    EXPECT_THAT(refusal(), HasSubstr("not an HDF5 file"));
    write_splocs(folder_ / "whole.h5", SequenceSource(spheres_));
    const std::string whole = TemporaryFolder::content(folder_ / "whole.h5");
    folder_.put("x.h5", whole.substr(0, whole.size() / 2));
    EXPECT_THAT(refusal(), HasSubstr("x.h5"));
}

TEST_F(SplocsFile, RefusesMissingAndOtherDataSets) {
    put_verts(spheres_, H5T_IEEE_F64LE);
    EXPECT_THAT(refusal(), AllOf(HasSubstr("x.h5[tris]"), HasSubstr("no data set")));
    put_tris(spheres_.faces, H5T_IEEE_F64LE);
    EXPECT_THAT(refusal(), AllOf(HasSubstr("x.h5[tris]"), HasSubstr("no integers")));
}

TEST_F(SplocsFile, RefusesVertsOfAnotherKind) {
    put_tris(spheres_.faces, H5T_STD_I32LE);
    const std::vector<int> numbers(2 * 3 * 3);
    put(path_, "verts", H5T_STD_I32LE, {2, 3, 3}, H5T_NATIVE_INT, numbers.data());
    EXPECT_THAT(refusal(), AllOf(HasSubstr("x.h5[verts]"), HasSubstr("floating-point")));
}

TEST_F(SplocsFile, RefusesVertsOfAnotherRank) {
    put_tris(spheres_.faces, H5T_STD_I32LE);
    const std::vector<double> numbers(6 * 3);
    put(path_, "verts", H5T_IEEE_F64LE, {6, 3}, H5T_NATIVE_DOUBLE, numbers.data());
    EXPECT_THAT(refusal(), HasSubstr("(6, 3), wanted (any, any, 3)"));
}

TEST_F(SplocsFile, RefusesFacesOutOfRange) {
    put_verts(spheres_, H5T_IEEE_F64LE);
    spheres_.faces[3][1] = 42;
    put_tris(spheres_.faces, H5T_STD_I32LE);
    EXPECT_THAT(refusal(), HasSubstr("face 3 refers to vertex 42, wanted 0 to 41"));
}

TEST_F(SplocsFile, RefusesNumbersThatAreNotFinite) {
    spheres_.shapes[2][4][1] = std::nan("");
    put_verts(spheres_, H5T_IEEE_F64LE);
    put_tris(spheres_.faces, H5T_STD_I32LE);
    const Contents contents = read_splocs(path_);
    EXPECT_NO_THROW(contents.shapes->shape(1));
    EXPECT_THAT(thrown_message<InputError>([&] { contents.shapes->shape(2); }),
                HasSubstr("[2, 4, 1] is nan"));
}

// A data set that was never written has any size one likes.
TEST_F(SplocsFile, RefusesSizesThatTheFileCannotHold) {
    put_tris(spheres_.faces, H5T_STD_I32LE);
    const hid_t file = H5Fopen(path_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    const std::vector<hsize_t> lengths{1000000, 2000000000, 3}, chunk{1, 1000, 3};
    const hid_t space = H5Screate_simple(3, lengths.data(), nullptr);
    const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(properties, 3, chunk.data());
    H5Dclose(
        H5Dcreate2(file, "verts", H5T_IEEE_F32LE, space, H5P_DEFAULT, properties, H5P_DEFAULT));
    H5Pclose(properties);
    H5Sclose(space);
    H5Fclose(file);
    EXPECT_THAT(refusal(), HasSubstr("in a file of"));
}

TEST_F(SplocsFile, NothingIsLeftOfAFileThatCannotBeFinished) {
    spheres_.shapes[2][1][0] = std::nan("");
    EXPECT_THROW(write_splocs(path_, SequenceSource(spheres_)), NumericalError);
    EXPECT_THAT(folder_.names(), IsEmpty());
}

// HDF5 itself writes to no disk, so none of its writes can fail without a word.
TEST_F(SplocsFile, OnAFullDiskTheEarlierFileStays) {
    folder_.put("x.h5", "earlier");
    for (const rlim_t room : {0, 100, 2000, 5000}) {
        const FullDisk full(room);
        EXPECT_THROW(write_splocs(path_, SequenceSource(spheres_)), IoError) << room;
    }
    EXPECT_EQ(TemporaryFolder::content(path_), "earlier");
    EXPECT_THAT(folder_.names(), ElementsAre("x.h5"));
}

#else

TEST(SplocsFile, ABuildWithoutHdf5SaysSo) {
    EXPECT_FALSE(has_hdf5());
    EXPECT_THAT(thrown_message<UsageError>([] { read_splocs("x.h5"); }), HasSubstr("no HDF5"));
    const MeshSequence spheres = stretched_spheres(1);
    EXPECT_THAT(thrown_message<UsageError>([&] { write_splocs("x.h5", SequenceSource(spheres)); }),
                HasSubstr("no HDF5"));
}

#endif

}  // namespace
}  // namespace mscomp
