// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cmath>

#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/convert/array_files.h"
#include "mscomp/convert/npy.h"
#include "mscomp/convert/zip.h"
#include "per_shape_arrays.h"

namespace mscomp {
namespace {

/// The numbers of a vector of fixed-size arrays, one after the other.
template <class Row>
auto flat(const std::vector<Row>& rows) {
    using T = typename Row::value_type;
    constexpr std::size_t size = std::tuple_size_v<Row>;
    static_assert(sizeof(Row) == size * sizeof(T));
    return std::span<const T>(reinterpret_cast<const T*>(rows.data()), rows.size() * size);
}

template <class T>
constexpr NpyType kNpyType = std::is_same_v<T, float>    ? NpyType::f32
                             : std::is_same_v<T, double> ? NpyType::f64
                                                         : NpyType::i32;

template <class T>
void require_finite(std::span<const T> numbers, const std::string& path, std::string_view what) {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (std::isfinite(numbers[i])) continue;
        throw NumericalError(
            fmt::format("{}: number {} of {} is not finite; nothing was written", path, i, what));
    }
}

/// Sink is ZipWriter or AtomicFile.
template <class Sink>
void write_vertices(Sink& sink, const std::string& path, const ShapeSource& shapes,
                    const ShapesDone& done) {
    sink.write(std::string_view(
        npy_header(NpyType::f64, {shapes.shape_count(), shapes.vertex_count(), 3}, 8)));
    for (int i = 0; i < shapes.shape_count(); ++i) {
        const std::vector<Point> points = shapes.shape(i);
        require_finite(flat(points), path, "a shape");
        sink.write(std::as_bytes(flat(points)));
        if (done) done(i + 1);
    }
}

class NpzWriter {
  public:
    explicit NpzWriter(const std::string& path) : path_(path), file_(path), zip_(file_) {}

    template <class T>
    void add(const std::string& name, const Shape& shape, std::span<const T> numbers) {
        if constexpr (std::is_floating_point_v<T>) require_finite(numbers, path_, name);
        add_unchecked(name, shape, numbers);
    }
    template <class T>
    void add_unchecked(const std::string& name, const Shape& shape, std::span<const T> numbers) {
        zip_.begin_file(name + ".npy");
        zip_.write(std::string_view(npy_header(kNpyType<T>, shape, sizeof(T))));
        zip_.write(std::as_bytes(numbers));
    }
    void add_per_shape(const PerShapeArray& array, const FeatureSet& set) {
        const std::span<const double> numbers(set.*array.numbers);
        if (numbers.empty()) return;
        if (!array.may_be_nan) require_finite(numbers, path_, array.name);
        add_unchecked(array.name, {static_cast<std::int64_t>(numbers.size())}, numbers);
    }
    void add_texts(const std::string& name, const std::vector<std::string>& texts,
                   bool scalar = false) {
        if (texts.empty()) return;
        zip_.begin_file(name + ".npy");
        zip_.write(std::string_view(npy_texts(texts, scalar)));
    }
    void add_vertices(const ShapeSource& shapes, const ShapesDone& done) {
        zip_.begin_file("vertices.npy");
        write_vertices(zip_, path_, shapes, done);
    }
    void commit() {
        zip_.finish();
        file_.commit();
    }

  private:
    const std::string& path_;
    AtomicFile file_;
    ZipWriter zip_;
};

Shape faces_shape(const std::vector<Face>& faces) {
    return {static_cast<std::int64_t>(faces.size()), 3};
}

}  // namespace

void write_npz(const std::string& path, const ShapeSource& shapes, const ShapesDone& done) {
    NpzWriter writer(path);
    writer.add_vertices(shapes, done);
    writer.add("faces", faces_shape(shapes.faces()), flat(shapes.faces()));
    writer.add_texts("names", shapes.names());
    writer.commit();
}

void write_npz(const std::string& path, const FeatureSet& set, const VertexPlaces& places) {
    const std::int64_t count = set.shape_count(), vertices = set.vertex_count();
    NpzWriter writer(path);
    writer.add("features", {count, vertices, kFeatureDim}, std::span<const float>(set.features));
    writer.add("vertices", {count, vertices, 3}, std::span<const float>(set.vertices));
    writer.add("reference", {vertices, 3}, flat(set.reference.vertices));
    writer.add("faces", faces_shape(set.reference.faces), flat(set.reference.faces));
    if (!places.are_all_vertices()) {
        writer.add("place", {vertices}, std::span<const int>(places.place_of_vertex()));
    }
    writer.add("rotation", {count, 3, 3}, flat(set.rotation));
    writer.add("translation", {count, 3}, flat(set.translation));
    for (const PerShapeArray& array : kPerShapeArrays) writer.add_per_shape(array, set);
    writer.add_texts("names", set.names);
    writer.add_texts("weights", {set.weights}, true);
    writer.add_texts("warnings", set.warnings);
    writer.commit();
}

void write_npy(const std::string& path, const ShapeSource& shapes, const ShapesDone& done) {
    AtomicFile file(path);
    write_vertices(file, path, shapes, done);
    file.commit();
}

void write_npy(const std::string& path, const FeatureSet& set) {
    const std::span<const float> features(set.features);
    require_finite(features, path, "features");
    AtomicFile file(path);
    file.write(std::string_view(
        npy_header(NpyType::f32, {set.shape_count(), set.vertex_count(), kFeatureDim}, 4)));
    file.write(std::as_bytes(features));
    file.commit();
}

}  // namespace mscomp
