// SPDX-License-Identifier: MIT
#include "mscomp/convert/splocs_file.h"

#include <fmt/format.h>
#include <hdf5.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <mutex>
#include <utility>

#include "array_checks.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/file_kind.h"
#include "mscomp/base/index.h"
#include "mscomp/base/paths.h"
#include "mscomp/base/readable_file.h"

namespace mscomp {
namespace {

constexpr std::uint64_t kCacheBytes = std::uint64_t{256} << 20;

/// An HDF5 identifier that is closed when it goes.
class HdfId {
  public:
    HdfId(hid_t id, herr_t (*closer)(hid_t)) : id_(id), closer_(closer) {}
    HdfId(HdfId&& other) noexcept : id_(std::exchange(other.id_, -1)), closer_(other.closer_) {}
    HdfId& operator=(HdfId&&) = delete;
    ~HdfId() {
        if (id_ >= 0) closer_(id_);
    }
    hid_t id() const { return id_; }
    bool is_open() const { return id_ >= 0; }

  private:
    hid_t id_;
    herr_t (*closer_)(hid_t);
};

void silence_hdf5() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

/// The lengths of a data set whose entries are of `type_class`.
Shape require_dataset(const HdfId& dataset, H5T_class_t type_class, const std::string& place,
                      const char* wanted) {
    if (!dataset.is_open()) throw InputError({place}, "is no data set of this file");
    const HdfId type(H5Dget_type(dataset.id()), H5Tclose);
    if (H5Tget_class(type.id()) != type_class) {
        throw InputError({place}, fmt::format("holds no {0}, wanted {0}", wanted));
    }
    const HdfId space(H5Dget_space(dataset.id()), H5Sclose);
    const int rank = H5Sget_simple_extent_ndims(space.id());
    std::array<hsize_t, H5S_MAX_RANK> lengths{};
    if (rank < 0 || H5Sget_simple_extent_dims(space.id(), lengths.data(), nullptr) < 0) {
        throw InputError({place}, "has no shape");
    }
    Shape shape;
    for (std::size_t i = 0; i < at(rank); ++i) {
        if (lengths[i] > std::numeric_limits<int>::max()) {
            throw InputError({place},
                             fmt::format("has an axis of {}, wanted at most 2^31 - 1", lengths[i]));
        }
        shape.push_back(static_cast<std::int64_t>(lengths[i]));
    }
    return shape;
}

/// What deflate cannot reach from this file is not in it; other filters pack no better.
void require_plausible(const Shape& shape, std::uint64_t file_size, const std::string& place) {
    constexpr double most_packed = 1100, floor = 1 << 20;
    double entries = 1;
    for (const std::int64_t length : shape) entries *= static_cast<double>(length);
    if (entries <= floor + most_packed * static_cast<double>(file_size)) return;
    throw InputError({place},
                     fmt::format("claims {} numbers in a file of {} bytes", entries, file_size));
}

class SplocsShapes final : public ShapeSource {
  public:
    explicit SplocsShapes(const std::string& path)
        : path_(path), file_(open(path)), verts_(open_dataset("verts")) {
        const std::uint64_t size = file_size(path);
        const std::string verts = place("verts"), tris = place("tris");
        const Shape shape = require_dataset(verts_, H5T_FLOAT, verts, "floating-point numbers");
        require_shape(shape, {-1, -1, 3}, verts);
        require_counts(shape[0], shape[1], verts);
        require_plausible(shape, size, verts);
        vertex_count_ = static_cast<int>(shape[1]);
        names_ = numbered_names(static_cast<int>(shape[0]));
        const HdfId dataset = open_dataset("tris");
        const Shape faces = require_dataset(dataset, H5T_INTEGER, tris, "integers");
        require_shape(faces, {-1, 3}, tris);
        require_plausible(faces, size, tris);
        faces_ = read_faces(dataset, faces, tris);
    }

    const std::vector<std::string>& names() const override { return names_; }
    const std::vector<Face>& faces() const override { return faces_; }
    int vertex_count() const override { return vertex_count_; }

    std::vector<Point> shape(int index) const override {
        std::vector<double> numbers(3 * at(vertex_count_));
        {
            const std::lock_guard<std::mutex> one_at_a_time(mutex_);  // HDF5 wants it
            const std::array<hsize_t, 3> begin{static_cast<hsize_t>(index), 0, 0};
            const std::array<hsize_t, 3> count{1, static_cast<hsize_t>(vertex_count_), 3};
            const HdfId there(H5Dget_space(verts_.id()), H5Sclose);
            const HdfId here(H5Screate_simple(3, count.data(), nullptr), H5Sclose);
            const bool selected = H5Sselect_hyperslab(there.id(), H5S_SELECT_SET, begin.data(),
                                                      nullptr, count.data(), nullptr) >= 0;
            if (!selected || H5Dread(verts_.id(), H5T_NATIVE_DOUBLE, here.id(), there.id(),
                                     H5P_DEFAULT, numbers.data()) < 0) {
                throw InputError({place("verts")}, fmt::format("shape {} cannot be read; the file "
                                                               "is damaged, or packed in a way "
                                                               "that this HDF5 does not know",
                                                               index));
            }
        }
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            if (std::isfinite(numbers[i])) continue;
            throw InputError({place("verts")}, fmt::format("[{}, {}, {}] is {}, wanted a finite "
                                                           "number",
                                                           index, i / 3, i % 3, numbers[i]));
        }
        return points_of(numbers);
    }

  private:
    static HdfId open(const std::string& path) {
        silence_hdf5();
        if (path_exists(path) && !is_regular_file(path)) {
            throw IoError(path, "is not a regular file, cannot be read");
        }
        const ReadableFile readable(path);  // says why it cannot be opened
        HdfId file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
        if (!file.is_open()) {
            const std::string bytes = read_file(path);
            if (!bytes.starts_with("\x89HDF")) refuse_other_kinds(bytes, path);
            throw InputError({path}, "is not an HDF5 file, or is damaged");
        }
        return file;
    }

    HdfId open_dataset(const char* name) const {
        // Chunks usually span many shapes: unpack each once for all of them.
        const HdfId access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
        H5Pset_chunk_cache(access.id(), 12421, kCacheBytes, 1.0);
        return {H5Dopen2(file_.id(), name, access.id()), H5Dclose};
    }

    std::vector<Face> read_faces(const HdfId& dataset, const Shape& shape,
                                 const std::string& tris) const {
        std::vector<long long> numbers(3 * at(shape[0]));
        if (H5Dread(dataset.id(), H5T_NATIVE_LLONG, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()) <
            0) {
            throw InputError({tris}, "cannot be read; the file is damaged");
        }
        std::vector<int> corners(numbers.size());
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            const bool fits = numbers[i] >= 0 && numbers[i] < vertex_count_;
            if (!fits) {
                throw InputError({tris}, fmt::format("face {} refers to vertex {}, wanted 0 to {}",
                                                     i / 3, numbers[i], vertex_count_ - 1));
            }
            corners[i] = static_cast<int>(numbers[i]);
        }
        return checked_faces(corners, vertex_count_, tris);
    }

    std::string place(const char* name) const { return fmt::format("{}[{}]", path_, name); }

    std::string path_;
    HdfId file_;
    HdfId verts_;
    int vertex_count_ = 0;
    std::vector<std::string> names_;
    std::vector<Face> faces_;
    mutable std::mutex mutex_;
};

/// HDF5 builds the file in memory: where it writes to a disk itself, a write that fails can go
/// unnoticed or end the program.
HdfId create_in_memory(const std::string& path) {
    constexpr std::size_t kGrowth = std::size_t{1} << 20;
    const HdfId access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    if (H5Pset_fapl_core(access.id(), kGrowth, false) < 0) return {-1, H5Fclose};
    return {H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.id()), H5Fclose};
}

class SplocsWriter {
  public:
    explicit SplocsWriter(const std::string& path) : path_(path), file_(create_in_memory(path)) {
        require(file_.is_open());
    }

    void write(const ShapeSource& shapes, const ShapesDone& done) {
        const std::array<hsize_t, 3> lengths{static_cast<hsize_t>(shapes.shape_count()),
                                             static_cast<hsize_t>(shapes.vertex_count()), 3};
        const std::array<hsize_t, 3> one{1, lengths[1], 3};
        const HdfId there(H5Screate_simple(3, lengths.data(), nullptr), H5Sclose);
        const HdfId here(H5Screate_simple(3, one.data(), nullptr), H5Sclose);
        const HdfId verts = create("verts", H5T_IEEE_F64LE, there);
        for (int i = 0; i < shapes.shape_count(); ++i) {
            const std::vector<Point> points = shapes.shape(i);
            for (const Point& point : points) require_finite(point);
            const std::array<hsize_t, 3> begin{static_cast<hsize_t>(i), 0, 0};
            require(H5Sselect_hyperslab(there.id(), H5S_SELECT_SET, begin.data(), nullptr,
                                        one.data(), nullptr) >= 0);
            require(H5Dwrite(verts.id(), H5T_NATIVE_DOUBLE, here.id(), there.id(), H5P_DEFAULT,
                             points.data()) >= 0);
            if (done) done(i + 1);
        }
        const std::array<hsize_t, 2> size{shapes.faces().size(), 3};
        const HdfId space(H5Screate_simple(2, size.data(), nullptr), H5Sclose);
        const HdfId tris = create("tris", H5T_STD_I32LE, space);
        require(H5Dwrite(tris.id(), H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT,
                         shapes.faces().data()) >= 0);
    }

    /// The bytes of the file.
    std::vector<std::byte> image() const {
        require(H5Fflush(file_.id(), H5F_SCOPE_GLOBAL) >= 0);
        const ssize_t size = H5Fget_file_image(file_.id(), nullptr, 0);
        require(size > 0);
        std::vector<std::byte> bytes(at(size));
        require(H5Fget_file_image(file_.id(), bytes.data(), bytes.size()) == size);
        return bytes;
    }

  private:
    HdfId create(const char* name, hid_t type, const HdfId& space) const {
        // Times of writing would make equal input differ.
        const HdfId properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
        H5Pset_obj_track_times(properties.id(), false);
        HdfId dataset(H5Dcreate2(file_.id(), name, type, space.id(), H5P_DEFAULT, properties.id(),
                                 H5P_DEFAULT),
                      H5Dclose);
        require(dataset.is_open());
        return dataset;
    }

    void require(bool succeeded) const {
        if (!succeeded) throw IoError(path_, "cannot be written: HDF5 reports a failure");
    }
    void require_finite(const Point& point) const {
        for (const double x : point) {
            if (std::isfinite(x)) continue;
            throw NumericalError(path_ + ": a position is not finite; nothing was written");
        }
    }

    const std::string& path_;
    HdfId file_;
};

}  // namespace

bool has_hdf5() { return true; }

Contents read_splocs(const std::string& path) {
    Contents contents;
    contents.shapes = std::make_unique<SplocsShapes>(path);
    contents.notes.emplace_back("names are shape_0000, ...");
    return contents;
}

void write_splocs(const std::string& path, const ShapeSource& shapes, const ShapesDone& done) {
    silence_hdf5();
    AtomicFile target(path);  // first: a place that cannot be written shows before the work
    SplocsWriter writer(path);
    writer.write(shapes, done);
    target.write(writer.image());
    target.commit();
}

}  // namespace mscomp
